"""Runs Mitsuba on a scene file; the other scripts start this in the Python that has its wheel.

    python mitsuba_render.py SCENE.xml --out IMAGE.npz --variant NAME --spp N --batches N
    python mitsuba_render.py SCENE.xml --variant NAME --spp N --batches N --size 256x256

Prints one line of JSON: paths of one batch, and the CPU seconds of each batch after a first one
that compiles.  IMAGE.npz holds S and its standard error from the scatter of the batches.
"""

import argparse
import json
import os
import resource
from pathlib import Path

import mitsuba as mi
import numpy as np
from mitsuba_figures import LUMINANCE, UNIT_LUMINANCE

LLVM = [
    "/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1",
    "/usr/lib/aarch64-linux-gnu/libLLVM.so.19.1",
    "/usr/lib/llvm-19/lib/libLLVM.so",
]


def cpu_seconds() -> float:
    """Return user and system time of all threads so far."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def use_llvm() -> bool:
    """Point Dr.Jit to LLVM 19 unless the user did; return whether there is one."""
    found = next((path for path in LLVM if Path(path).exists()), None)
    if found:
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", found)
    return "DRJIT_LIBLLVM_PATH" in os.environ


def stokes_of(images: np.ndarray, variant: str, luminance: bool) -> np.ndarray:
    """Return S [..., 4, C] of films: one number in mono variants and with `luminance`."""
    # the film's own channels come first, then S0.R … S3.B
    stokes = images.astype(float)[..., -12:]
    stokes = stokes.reshape(*stokes.shape[:-1], 4, 3)
    if "mono" in variant:
        stokes = stokes[..., :1]
    elif luminance:
        stokes = (stokes @ LUMINANCE)[..., None] / UNIT_LUMINANCE
    return stokes


def main() -> None:
    """Render the batches."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene")
    parser.add_argument("--out")
    parser.add_argument("--variant", required=True)
    parser.add_argument("--spp", type=int, required=True, help="samples of one batch")
    parser.add_argument("--batches", type=int, required=True)
    parser.add_argument("--size", help="WxH")
    parser.add_argument("--luminance", action="store_true", help="reduce colours to one number")
    args = parser.parse_args()
    if args.variant.startswith("llvm") and not use_llvm():
        raise SystemExit("no LLVM 19: set DRJIT_LIBLLVM_PATH (Debian: libllvm19)")
    mi.set_variant(args.variant)
    mi.set_log_level(mi.LogLevel.Error)
    size = {}
    if args.size:
        width, height = args.size.split("x")
        size = {"width": int(width), "height": int(height)}
    scene = mi.load_file(args.scene, **size)
    images, seconds = [], []
    np.array(mi.render(scene, spp=args.spp, seed=999))
    for seed in range(args.batches):
        start = cpu_seconds()
        images.append(np.array(mi.render(scene, spp=args.spp, seed=seed)))
        seconds.append(cpu_seconds() - start)
    if args.out:
        stokes = stokes_of(np.stack(images), args.variant, args.luminance)
        error = stokes.std(0, ddof=1) / np.sqrt(args.batches)
        np.savez_compressed(args.out, S=stokes.mean(0), stderr=error)
    height, width = images[0].shape[:2]
    print(json.dumps({"paths": width * height * args.spp, "cpu_s": seconds}))


if __name__ == "__main__":
    main()
