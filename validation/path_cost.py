"""Where a path's instructions go: prints a Markdown table of shares by source folder.

    validation/.venv/bin/python validation/path_cost.py [SCENE …]

Valgrind's callgrind counts every instruction of renders of 16×16 pixels in one thread, at one
wavelength, with two numbers of samples; their difference is what paths take.  An instruction
belongs to the innermost function of ours that it was inlined from, past arithmetic on lanes and
past libraries, and so to a folder of crates/render/src.  Callgrind knows AVX2: eight lanes.

Needs valgrind, addr2line and nm.  Builds the program with line tables in target/path_cost; with
`--program FILE` it takes a build that has them:

    CARGO_PROFILE_RELEASE_DEBUG=line-tables-only cargo build --release --bin brewster
"""

import os
import shutil
import subprocess
import tempfile
from collections import Counter
from pathlib import Path

import origin
from benchmark_scenes import SIX
from common import ROOT, SCENES, arguments, binary, give_up

# column: folders and files of crates/render/src; the rest is "other"
COLUMNS = {
    "geometry": ("geometry", "shape", "scene"),
    "material": ("material",),
    "lights": ("emitter", "lights"),
    "path": ("path",),
    "light": ("light",),
    "sampler": ("sampler",),
    "spectrum": ("spectrum", "colour", "ior"),
    "film, engine": ("film", "engine", "sensor", "filter", "image"),
}
# code of no subject of its own: what it was inlined into counts
ANYWHERE = ("lanes", "intrinsics")
SOURCES = "crates/render/src/"
FEW, MANY, SIZE = 32, 96, 16
Costs = Counter[int]


def built() -> Path:
    """Build the program with line tables."""
    os.environ["CARGO_PROFILE_RELEASE_DEBUG"] = "line-tables-only"
    os.environ.setdefault("CARGO_TARGET_DIR", str(ROOT / "target" / "path_cost"))
    os.environ.pop("BREWSTER", None)
    return Path(binary())


def counted(program: Path, scene: Path, spp: int, options: list[str]) -> tuple[Costs, int]:
    """Return instructions by address in the program, and those elsewhere."""
    with tempfile.TemporaryDirectory() as name:
        out = Path(name) / "callgrind.out"
        command = ["valgrind", "--tool=callgrind", "--dump-instr=yes", "--compress-pos=no"]
        command += ["--compress-strings=no", f"--callgrind-out-file={out}", str(program), "render"]
        command += [str(scene), "-o", f"{name}/image.exr", "--size", f"{SIZE}x{SIZE}"]
        command += ["--threads", "1", "--spp", str(spp), "--quiet", *options]
        if subprocess.run(command, stderr=subprocess.DEVNULL).returncode != 0:
            give_up(f"failed: {' '.join(command)}")
        return parsed(out, program)


def parsed(out: Path, program: Path) -> tuple[Costs, int]:
    """Read a file of callgrind; addresses as the program's file has them."""
    costs: Costs = Counter()
    elsewhere, ours, start = 0, False, None
    inclusive, in_main = False, False
    with out.open(encoding="utf-8") as lines:
        for line in lines:
            if line.startswith("ob="):
                ours = Path(line[3:].strip()).name == program.name
            elif line.startswith("fn="):
                in_main = line[3:].strip() == "main"
            elif line.startswith("calls="):
                # the next line counts what is called
                inclusive = True
            elif line.startswith("0x"):
                address, _, cost = line.split()
                if ours and in_main:
                    here = int(address, 16)
                    start = here if start is None else min(start, here)
                if inclusive:
                    inclusive = False
                elif ours:
                    costs[int(address, 16)] += int(cost)
                else:
                    elsewhere += int(cost)
    if start is None:
        give_up("callgrind has not seen the program's main")
    symbols = subprocess.run(["nm", str(program)], text=True, capture_output=True).stdout
    main = next(int(s.split()[0], 16) for s in symbols.splitlines() if s.endswith(" T main"))
    return Counter({at - start + main: cost for at, cost in costs.items()}), elsewhere


def subject(frames: list[str]) -> str:
    """Return the column of an instruction, from the files it was inlined from, innermost first."""
    for frame in frames:
        _, ours, place = frame.partition(SOURCES)
        name = place.partition("/")[0].partition(".")[0].partition(":")[0]
        if ours and name not in ANYWHERE:
            return next((k for k, folders in COLUMNS.items() if name in folders), "other")
    return "other"


def subjects(program: Path, addresses: list[int]) -> dict[int, str]:
    """Return the column of every address."""
    text = subprocess.run(
        ["addr2line", "-a", "-i", "-e", str(program)],
        input="\n".join(map(hex, addresses)), text=True, stdout=subprocess.PIPE, check=True,
    ).stdout  # fmt: skip
    frames: dict[int, list[str]] = {}
    at = 0
    for line in text.splitlines():
        if line.startswith("0x"):
            at = int(line, 16)
            frames[at] = []
        else:
            frames[at].append(line)
    return {at: subject(found) for at, found in frames.items()}


def shares(program: Path, scene: Path, options: list[str]) -> tuple[float, dict[str, float]]:
    """Return instructions a path, and the share of each column."""
    (few, few_else), (many, many_else) = (
        counted(program, scene, spp, options) for spp in (FEW, MANY)
    )
    difference = {at: cost - few[at] for at, cost in many.items() if cost != few[at]}
    of = subjects(program, list(difference))
    sums = dict.fromkeys([*COLUMNS, "other"], 0.0)
    for at, cost in difference.items():
        sums[of[at]] += cost
    sums["other"] += many_else - few_else
    whole = sum(sums.values())
    paths = (MANY - FEW) * SIZE * SIZE
    return whole / paths, {column: part / whole for column, part in sums.items()}


def main() -> int:
    """Count, and print the table."""
    parser = arguments(__doc__)
    parser.add_argument("scenes", nargs="*", help=f"names (default: {' '.join(SIX)})")
    parser.add_argument("--program", type=Path, help="a build with line tables")
    parser.add_argument("--rgb", action="store_true", help="all wavelengths")
    args = parser.parse_args()
    for tool in ("valgrind", "addr2line", "nm"):
        if shutil.which(tool) is None:
            give_up(f"{tool} is needed")
    program = args.program or built()
    head = ["scene", "instructions a path", *COLUMNS, "other"]
    print(f"{origin.made('brewster')}\n\n| {' | '.join(head)} |\n|---{'|---:' * (len(head) - 1)}|")
    for name in args.scenes or SIX:
        options = ["--rgb"] if args.rgb else []
        count, parts = shares(program, SCENES / name / "scene.xml", options)
        cells = [f"{part:.0%}" for part in parts.values()]
        print(f"| {name} | {count:.0f} | {' | '.join(cells)} |", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
