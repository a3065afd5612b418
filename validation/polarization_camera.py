"""Frames of a polarization camera, put together again with numpy, against the Stokes image.

    showroom, --analyzer camera,mosaic,linear:20deg,lcp

From the four frames and their 16-bit pictures S0, S1, S2 follow as on a real camera; the raw
mosaic must hold the pixels of those frames in the cell 90 45 / 135 0; an analyzer's image is its
row of Mueller calculus.  Nothing here has noise: all tolerances are round-off, of 32 bits in the
images and of one level in the pictures.
"""

import json
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
from common import ROUND_OFF, SCENES, Array, Report, arguments, read, render
from PIL import Image

CELL = ((90, 45), (135, 0))
ANGLES = (0, 45, 90, 135)


def intensity(path: Path) -> Array:
    """Read the only component of a detector's image."""
    with OpenEXR.File(str(path), separate_channels=True) as exr:
        return np.asarray(exr.channels()["S0"].pixels, np.float64)


def linear_stokes(frames: dict[int, Array]) -> Array:
    """Return S0, S1, S2 [H,W,3] as polarization cameras compute them."""
    total = sum(frames.values()) / 2
    return np.stack([total, frames[0] - frames[90], frames[45] - frames[135]], -1)


def main() -> int:
    """Render, recombine, compare."""
    arguments(__doc__).parse_args()
    report = Report("polarization camera")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "a.exr"
        wanted = "camera,mosaic,linear:20deg,lcp"
        render(
            SCENES / "showroom" / "scene.xml",
            out,
            "--spp",
            "4",
            "--size",
            "120x80",
            "--analyzer",
            wanted,
        )
        s = read(out).mean[..., 0]
        frames = {angle: intensity(out.with_suffix(f".camera{angle:03}.exr")) for angle in ANGLES}
        white = json.loads((Path(folder) / "a_analyzers.json").read_text())["white"]
        pictures = {
            angle: np.asarray(Image.open(out.with_suffix(f".camera{angle:03}.png")), np.float64)
            for angle in ANGLES
        }
        mosaic = intensity(out.with_suffix(".mosaic.exr"))
        behind = {
            name: read(out.with_suffix(f".{name}.exr")).mean[..., 0] for name in ("linear20", "lcp")
        }
    scale = np.maximum(s[..., :1], 1e-6)
    from_frames = linear_stokes(frames)
    report.within(
        "frames: S0 S1 S2", float((abs(from_frames - s[..., :3]) / scale).max()), ROUND_OFF
    )
    level = white / 65535
    unsaturated = np.all([p < 65535 for p in pictures.values()], 0)
    from_pictures = linear_stokes({a: p * level for a, p in pictures.items()})
    off = abs(from_pictures - s[..., :3])[unsaturated].max() / level
    report.within("16-bit pictures: S0 S1 S2, levels", float(off), 1.02)
    report.within("saturated share", float(1 - unsaturated.mean()), 0.05)
    for row, angles in enumerate(CELL):
        for column, angle in enumerate(angles):
            place = np.s_[row::2, column::2]
            report.within(
                f"mosaic: {angle} at ({row}, {column})",
                float(abs(mosaic[place] - frames[angle][place]).max()),
                0.0,
            )
    two = 2 * np.radians(20)
    rows = {"linear20": (1, np.cos(two), np.sin(two), 0), "lcp": (1, 0, 0, -1)}
    for name, row in rows.items():
        expected = 0.5 * (s @ np.array(row))[..., None] * np.array(row)
        report.within(name, float((abs(behind[name] - expected) / scale).max()), ROUND_OFF)
    return report.finish()


if __name__ == "__main__":
    sys.exit(main())
