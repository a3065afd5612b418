#!/usr/bin/env python3
"""Prints what coherence patches gain over plane-wave sampling, and what bias they cost.

    validation/.venv/bin/python validation/coherence_gain.py [SCENE …]

Both ways run in the same program, taking turns.  Gain: CPU seconds of plane waves (`--patch 0`)
over CPU seconds of patches for the same error, from the variances of both images: time × variance
is what a sampler costs.  Bias: root of the mean squared difference of S0 between two long
renderings, in 48 parts of the image, beyond their noise and over the mean; with what the noise
alone would let one see.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import origin
from common import ROOT, Array, Image, arguments, read, render

# scene file, and what to put into it
CASES: dict[str, tuple[str, list[str]]] = {
    "compact_disc": ("scenes/compact_disc/scene.xml", []),
    "compact_disc, large lamp": (
        "scenes/compact_disc/scene.xml",
        ["-D", "lamp=0.06", "-D", "radiance=1.8"],
    ),
    "ground plate": ("validation/ground_plate.xml", []),
    "ground plate, larger lamp": ("validation/ground_plate.xml", ["-D", "lamp=0.02"]),
    "roughness_series": ("scenes/roughness_series/scene.xml", []),
    "double_slit": ("scenes/double_slit/scene.xml", []),
}
PLANE = ["--patch", "0"]


def measure(scene: Path, spp: int, seed: int, options: list[str]) -> tuple[Image, float]:
    """Render once; return the image and CPU seconds of sampling."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "image.exr"
        told = render(scene, out, "--spp", str(spp), "--seed", str(seed), *options)
        return read(out), float(told["sampling_cpu_s"])


def cost(runs: list[tuple[Image, float]], spp: int) -> Array:
    """Return CPU seconds × variance of a sample for each Stokes component."""
    seconds = min(t for _, t in runs) / spp
    variance = np.mean([image.variance.mean((0, 1, 3)) for image, _ in runs], 0) * spp
    return seconds * variance


def bias(patches: Image, plane: Image) -> tuple[float, float]:
    """Return the relative root mean squared bias of S0, and how much noise alone would show."""
    parts = 8, 6

    def sums(values: Array) -> Array:
        columns = np.array_split(values, parts[0], axis=1)
        return np.array([[p.mean() for p in np.array_split(c, parts[1], axis=0)] for c in columns])

    level = plane.mean[:, :, 0].mean()
    difference = sums((patches.mean - plane.mean)[:, :, 0])
    # of the mean of a part: the mean variance over its number of values
    size = plane.mean[:, :, 0].size / difference.size
    variance = sums((patches.variance + plane.variance)[:, :, 0]) / size
    excess = (difference**2 - variance).mean()
    # the squares of normal deviates have twice the square of their variance
    spread = np.sqrt(2.0 * (variance**2).sum()) / variance.size
    return float(np.sqrt(max(excess, 0.0)) / level), float(np.sqrt(spread) / level)


def main() -> int:
    """Measure every scene and print a Markdown table."""
    parser = arguments(__doc__)
    parser.add_argument("scenes", nargs="*", help=f"of {', '.join(CASES)} (default: all)")
    parser.add_argument("--spp", type=int, default=32, help="samples a pixel (default 32)")
    parser.add_argument("--long", type=int, default=1024, help="those of the bias (default 1024)")
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--size", default="96x96")
    args = parser.parse_args()
    if unknown := set(args.scenes) - set(CASES):
        parser.error(f"no case {', '.join(sorted(unknown))}, expected of {', '.join(CASES)}")
    print(f"{origin.made('brewster')}\n")
    print("| scene | gain at equal error: S0 | S1 | S2 | S3 | bias of S0 | seen above |")
    print("|---|---|---|---|---|---|---|")
    for name in args.scenes or CASES:
        file, options = CASES[name]
        scene = ROOT / file
        options = ["--size", args.size, *options]
        runs: dict[str, list[tuple[Image, float]]] = {"plane": [], "patches": []}
        for seed in range(args.repetitions):
            runs["plane"].append(measure(scene, args.spp, seed, [*options, *PLANE]))
            runs["patches"].append(measure(scene, args.spp, seed, options))
        plane, patches = (cost(runs[kind], args.spp) for kind in ("plane", "patches"))
        gains = [
            f"{a / b:.1f}" if b > 0 and a > 0 else "–" for a, b in zip(plane, patches, strict=True)
        ]
        long_plane, _ = measure(scene, args.long, 11, [*options, *PLANE])
        long_patches, _ = measure(scene, args.long, 12, options)
        off, error = bias(long_patches, long_plane)
        row = [name, *gains, f"{off:.2%}", f"{error:.2%}"]
        print(f"| {' | '.join(row)} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
