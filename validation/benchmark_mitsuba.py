"""Runs Mitsuba over a ladder of budgets; `benchmark_error.py` starts this in the Python with it.

    python benchmark_mitsuba.py SCENE.xml --variant NAME --budgets 1,4,16 --seed N --out IMAGES.npz

IMAGES.npz holds S, [H,W,4], of each budget by its number; in spectral variants the luminance over
that of the unit spectrum.  One line of JSON: CPU seconds of each budget, and of a pass of --pass
samples at --size; seconds and CPU seconds of loading, and of the first render beyond a second one,
which is what compiling takes (nothing where the kernels are cached in $HOME).
"""

import argparse
import json
import time

import mitsuba as mi
import mitsuba_render
import numpy as np

# samples of one wavefront at most
WAVEFRONT = 256


def clock() -> np.ndarray:
    """Return the time now: seconds, CPU seconds of all threads."""
    return np.array([time.monotonic(), mitsuba_render.cpu_seconds()])


def main() -> None:
    """Load, compile, render every budget."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("--variant", required=True)
    parser.add_argument("--budgets", required=True, help="samples a pixel, with commas")
    parser.add_argument("--seed", type=int, required=True, help="of the first budget")
    parser.add_argument("--out", required=True)
    parser.add_argument("--film", help="WxH (default: the scene's)")
    parser.add_argument("--size", required=True, help="WxH of the pass that is timed alone")
    parser.add_argument("--pass", dest="samples", type=int, required=True)
    args = parser.parse_args()
    if args.variant.startswith("llvm") and not mitsuba_render.use_llvm():
        raise SystemExit("no LLVM 19: set DRJIT_LIBLLVM_PATH (Debian: libllvm19)")
    mi.set_variant(args.variant)
    mi.set_log_level(mi.LogLevel.Error)

    def load(size: str | None) -> mi.Scene:
        width, height = size.split("x") if size else (0, 0)
        return mi.load_file(args.scene, **({"width": width, "height": height} if size else {}))

    def rendered(scene: mi.Scene, spp: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
        start = clock()
        image = np.array(mi.render(scene, spp=spp, seed=seed))
        return image, clock() - start

    start = clock()
    scene = load(args.film)
    loaded = clock() - start
    first = rendered(scene, 1, 1)[1]
    steady = rendered(scene, 1, 2)[1]
    images, cpu = {}, []
    for i, budget in enumerate(int(b) for b in args.budgets.split(",")):
        passes = -(-budget // WAVEFRONT)
        spent, films = 0.0, []
        for k in range(passes):
            film, taken = rendered(scene, budget // passes, args.seed + 1000 * i + k)
            films.append(film)
            spent += taken[1]
        stokes = mitsuba_render.stokes_of(np.mean(films, axis=0), args.variant, luminance=True)
        images[str(budget)] = stokes[..., 0].astype(np.float32)
        cpu.append(spent)
    np.savez(args.out, **images)
    large = load(args.size)
    rendered(large, args.samples, 3)
    image, taken = rendered(large, args.samples, 4)
    paths = image.shape[0] * image.shape[1] * args.samples
    report = {
        "version": mi.__version__,
        "cpu_s": cpu,
        "pass": {"paths": paths, "cpu_s": taken[1]},
        "load": list(loaded),
        "compile": list(np.maximum(first - steady, 0)),
    }
    print(json.dumps(report))


if __name__ == "__main__":
    main()
