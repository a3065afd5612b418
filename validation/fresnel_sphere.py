"""The two glass spheres against closed forms computed in numpy alone.

    fresnel_sphere   (Rs ± Rp)/2 of the first reflection, turned into each ray's sensor frame
    furnace_sphere   S = (1, 0, 0, 0): a lossless body in a uniform unpolarized field

Both in unit unpolarized light from everywhere.  Component by component, z-test over blocks of
8×8 pixels, significance 1e-3 for all blocks and components together (Šidák).
"""

import sys
import tempfile
from pathlib import Path

import camera
import numpy as np
import optics
from common import INDEPENDENT, SCENES, Array, Report, arguments, blocks, read, render

SIZE = (96, 96)
DISTANCE = 4.0
FIELD_OF_VIEW = 32.0
INDEX = 1.5
SUPERSAMPLES = 24
BLOCK = 8


def brewster_ring() -> Array:
    """Return the Stokes image [H,W,4,1] of the sphere that reflects once."""
    rays = camera.look_at((0, 0, DISTANCE), (0, 0, 0), FIELD_OF_VIEW, SIZE, SUPERSAMPLES)
    d = rays.direction
    # |origin + t d| = 1
    b = camera.dot(rays.origin, d)
    discriminant = b**2 - (camera.dot(rays.origin, rays.origin) - 1)
    hit = discriminant >= 0
    t = -b - np.sqrt(np.where(hit, discriminant, 0))
    normal = rays.origin + t[..., None] * d
    cos = np.clip(-camera.dot(normal, d), 1e-9, 1)
    r_s, r_p = optics.reflection_amplitudes(1.0, INDEX, cos)
    total, linear = (abs(r_s) ** 2 + abs(r_p) ** 2) / 2, (abs(r_s) ** 2 - abs(r_p) ** 2) / 2
    phi = rays.angle_of(np.cross(normal, -d))
    zero = np.zeros_like(total)
    ring = np.stack([total, linear * np.cos(2 * phi), linear * np.sin(2 * phi), zero], -1)
    sky = np.array([1.0, 0.0, 0.0, 0.0])
    return np.where(hit[..., None], ring, sky).mean(2)[..., None]


def main() -> int:
    """Render both spheres and compare."""
    parser = arguments(__doc__)
    parser.add_argument("--spp", type=int, default=256, help="samples a pixel (default 256)")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    furnace = np.zeros((SIZE[1], SIZE[0], 4, 1))
    furnace[:, :, 0] = 1
    report = Report("Glass spheres in unit light, against numpy")
    for name, expected in (("fresnel_sphere", brewster_ring()), ("furnace_sphere", furnace)):
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "image.exr"
            size = f"{SIZE[0]}x{SIZE[1]}"
            options = ["--spp", str(args.spp), "--seed", str(args.seed), "--size", size]
            options += INDEPENDENT
            render(SCENES / name / "scene.xml", out, *options)
            image = read(out)
        # every path of fresnel_sphere ends in S0 = 0 or 1
        binomial = np.zeros_like(expected)
        binomial[:, :, 0] = expected[:, :, 0] * (1 - expected[:, :, 0]) / args.spp
        report.same_image(name, image, expected, block=BLOCK, least_variance=binomial)
        # the stated variance must be the scatter that is seen
        noisy = blocks(image.variance, BLOCK) > 1e-12
        z2 = blocks(image.mean - expected, BLOCK)[noisy] ** 2 / blocks(image.variance, BLOCK)[noisy]
        spread = abs(z2.mean() - 1) / np.sqrt(2 / z2.size)
        report.within(f"{name}: |mean z² − 1| in standard deviations", float(spread), 4.0)
    return report.finish()


if __name__ == "__main__":
    sys.exit(main())
