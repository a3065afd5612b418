"""Runs Mitsuba on the same scene files where its wheel is installed, and compares the images.

Component by component, z-test over blocks of 8×8 pixels with the standard errors of both images,
significance 1e-3 for all blocks and components of a scene together (Šidák).  Skipped with status
0 (2 with --require) where Mitsuba is missing.  The variants are llvm_ad_mono_polarized and, for
the spectral scene, llvm_ad_spectral_polarized (LLVM 19, Debian: libllvm19), or with --scalar
scalar_spectral_polarized, which needs no LLVM and is ten times slower.
"""

import sys
import tempfile
from pathlib import Path

import mitsuba_peer
import numpy as np
from common import INDEPENDENT, REFERENCES, SCENES, Report, arguments, read, render, skip

SPECTRAL = {"cornell_spectral"}
# Mitsuba does not project the axis of an oblique retarder (docs of `retarder`)
PEER_ERROR = {"polarizer_stack": 1e-3}
# colour matching functions at 5 nm there and at 1 nm here
SPECTRAL_ERROR = 2e-3
BATCHES = 16
BLOCK = 8


def main() -> int:
    """Render every scene twice."""
    parser = arguments(__doc__)
    parser.add_argument("scenes", nargs="*", help="names (default: the eight with references)")
    parser.add_argument(
        "--spp", type=int, default=128, help="samples a pixel of each (default 128)"
    )
    parser.add_argument("--scalar", action="store_true", help="scalar_spectral_polarized")
    mitsuba_peer.add_arguments(parser)
    args = parser.parse_args()
    if not mitsuba_peer.installed(args.python):
        return skip(mitsuba_peer.MISSING, required=args.require)
    report = Report("Mitsuba on the same files")
    for name in args.scenes or sorted(p.stem for p in REFERENCES.glob("*.npz")):
        spectral = name in SPECTRAL
        variant = f"llvm_ad_{'spectral' if spectral else 'mono'}_polarized"
        options = ["--spp", str(max(args.spp // BATCHES, 1)), "--batches", str(BATCHES)]
        if args.scalar:
            variant = "scalar_spectral_polarized"
            options += [] if spectral else ["--luminance"]
        scene = SCENES / name / "scene.xml"
        with tempfile.TemporaryDirectory() as folder:
            theirs, ours = Path(folder) / "peer.npz", Path(folder) / "image.exr"
            options += ["--variant", variant, "--out", str(theirs)]
            mitsuba_peer.run(args.python, scene, *options)
            mode = ["--rgb"] if spectral else []
            render(scene, ours, "--spp", str(args.spp), *INDEPENDENT, *mode)
            peer = np.load(theirs)
            stokes, error = peer["S"], peer["stderr"]
            image = read(ours)
        image.variance = image.variance + error**2
        systematic = PEER_ERROR.get(name, 0.0) + SPECTRAL_ERROR * spectral * stokes.mean()
        report.same_image(name, image, stokes, block=BLOCK, systematic=systematic)
    return report.finish()


if __name__ == "__main__":
    sys.exit(main())
