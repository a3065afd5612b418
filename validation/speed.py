"""Camera paths per core-second, polarized and not, beside Mitsuba; prints a Markdown table.

Six scenes at 256×256.  CPU seconds of all threads while sampling; loading, building and JIT are
left out on both sides.  Each figure is the best of --repetitions.  Mitsuba's figures come from
`mitsuba_speed.json` and, where its wheel is installed, from the same run, the programs taking
turns.  Ratios above 1 mean that Brewster is faster; `cost` is polarized over unpolarized time.

With --against another build of Brewster the two take turns instead: CPU time of this build over
that of the other, for the same samples and, times the ratio of the variances, for the same error
of S0 and of S1 to S3 together; medians over the turns.

With --instructions this build is measured without the vector instructions of the processor, with
AVX2 and with all that it has.
"""

import json
import os
import sys
import tempfile
from pathlib import Path

import mitsuba_peer
import numpy as np
import origin
from common import SCENES, Array, arguments, read, render, skip

PEER_FIGURES = Path(__file__).parent / "mitsuba_speed.json"
VARIANT = "llvm_ad_mono_polarized"
SIZE = "256x256"
# samples of a pass, as the peer's figures were taken
PASS = 16


def brewster(scene: Path, spp: int, *options: str, program: str | None = None) -> float:
    """Return 10⁶ paths per core-second of one render."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "image.exr"
        told = render(scene, out, "--size", SIZE, "--spp", str(spp), *options, program=program)
    return told["paths"] / told["sampling_cpu_s"] / 1e6


def mitsuba(python: str, scene: Path) -> float:
    """Return 10⁶ paths per core-second, the best of three passes."""
    options = ["--variant", VARIANT, "--size", SIZE, "--spp", str(PASS), "--batches", "3"]
    told = mitsuba_peer.run(python, scene, *options)
    return told["paths"] / min(told["cpu_s"]) / 1e6


def measured(scene: Path, spp: int, seed: int, program: str | None = None) -> Array:
    """Return CPU seconds of sampling, and those times the variance of S0 and of S1 to S3."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "image.exr"
        options = ["--size", SIZE, "--spp", str(spp), "--seed", str(seed)]
        told = render(scene, out, *options, program=program)
        variance = read(out).variance.mean((0, 1, 3))
    return told["sampling_cpu_s"] * np.array([1.0, variance[0], variance[1:].sum()])


def against(other: str, names: list[str], spp: int, repetitions: int) -> None:
    """Print the CPU time of this build over that of another, scene by scene."""
    print("| scene | same samples | same error of S0 | of S1 to S3 |")
    print("|---" * 4 + "|")
    for name in names:
        scene = SCENES / name / "scene.xml"
        turns = []
        for seed in range(1, repetitions + 1):
            theirs, ours = measured(scene, spp, seed, other), measured(scene, spp, seed)
            turns.append(np.where(theirs > 0, ours / np.where(theirs > 0, theirs, 1), np.nan))
        cells = " | ".join("–" if np.isnan(x) else f"{x:.2f}" for x in np.median(turns, axis=0))
        print(f"| {name} | {cells} |", flush=True)


def instructions(names: list[str], spp: int, repetitions: int) -> None:
    """Print 10⁶ paths per core-second with each kind of vector instructions, scene by scene."""
    kinds = {"portable": "portable", "AVX2": "avx2", "all there are": ""}
    print(f"10⁶ paths per core-second, 256×256\n\n{origin.made('brewster')}\n")
    print(f"| scene | {' | '.join(kinds)} |")
    print("|---" * (len(kinds) + 1) + "|")
    for name in names:
        scene = SCENES / name / "scene.xml"
        best = dict.fromkeys(kinds, 0.0)
        for _ in range(repetitions):
            for kind, wish in kinds.items():
                os.environ["BREWSTER_SIMD"] = wish
                best[kind] = max(best[kind], brewster(scene, spp))
        print(f"| {name} | {' | '.join(f'{x:.3f}' for x in best.values())} |", flush=True)


def main() -> int:
    """Measure every scene and print the table."""
    parser = arguments(__doc__)
    figures = json.loads(PEER_FIGURES.read_text())["polarized"]
    parser.add_argument("scenes", nargs="*", help=f"names (default: {' '.join(figures)})")
    parser.add_argument("--spp", type=int, default=32, help="samples a pixel (default 32)")
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--against", metavar="PROGRAM", help="another build of Brewster")
    parser.add_argument("--instructions", action="store_true", help="compare vector instructions")
    mitsuba_peer.add_arguments(parser)
    args = parser.parse_args()
    if args.instructions:
        instructions(args.scenes or list(figures), args.spp, args.repetitions)
        return 0
    if args.against:
        against(args.against, args.scenes or list(figures), args.spp, args.repetitions)
        return 0
    beside = mitsuba_peer.installed(args.python)
    if args.require and not beside:
        return skip(mitsuba_peer.MISSING, required=True)

    print(f"10⁶ paths per core-second, 256×256\n\n{origin.made('brewster')}\n")
    now = " Mitsuba now | ratio |" if beside else ""
    print(f"| scene | Brewster | unpolarized | cost | Mitsuba, stored | ratio |{now}")
    print("|---" * (8 if beside else 6) + "|")
    for name in args.scenes or figures:
        scene = SCENES / name / "scene.xml"
        polarized, unpolarized, peer = 0.0, 0.0, 0.0
        for _ in range(args.repetitions):
            polarized = max(polarized, brewster(scene, args.spp))
            unpolarized = max(unpolarized, brewster(scene, args.spp, "--unpolarized"))
            if beside:
                peer = max(peer, mitsuba(args.python, scene))
        stored = figures[name]
        row = [name, f"{polarized:.3f}", f"{unpolarized:.3f}", f"{unpolarized / polarized:.2f}"]
        row += [f"{stored:.3f}", f"{polarized / stored:.2f}"]
        row += [f"{peer:.3f}", f"{polarized / peer:.2f}"] if beside else []
        print(f"| {' | '.join(row)} |", flush=True)
    if not beside:
        print(f"\nMitsuba was not measured: {mitsuba_peer.MISSING}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
