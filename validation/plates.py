"""Polarizers, retarders and circular polarizers before a lamp, against Mueller calculus.

    polarizer_stack     twelve cells: Malus, three plates, wave plates, plates seen from the back
    tilted_polarizers   pairs of oblique polarizers under a wide camera (effective axis after
                        Korger et al. 2013), each pixel in its own sensor frame

The plates are read from the scene file; each ray's light goes through them from the lamp to the
sensor.  The scenes have no noise but where a pixel sees an edge, so single pixels are tested:
z-test, significance 1e-3 for all pixels and components together (Šidák), with an allowance for
the finite supersampling of edges.
"""

import sys
import tempfile
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import camera
import numpy as np
import optics
from common import INDEPENDENT, SCENES, Array, Report, arguments, read, render
from scipy import ndimage

SUPERSAMPLES = 12
# in units of S: rays and frames in 32 bits
GEOMETRY = 2e-5


@dataclass
class View:
    """Where a scene's camera stands."""

    origin: tuple[float, float, float]
    fov_x: float
    size: tuple[int, int]


VIEWS = {
    "polarizer_stack": View((0, 0, 5000), 0.0496, (128, 96)),
    "tilted_polarizers": View((0.8, 0.6, 5), 44, (128, 88)),
}


@dataclass
class Plate:
    """A rectangle: its matrix to the world, and its `kind` with parameters."""

    to_world: Array
    kind: str
    parameters: dict[str, str]
    radiance: float

    def degrees(self, name: str) -> float:
        """Return a parameter in radians that the file gives in degrees."""
        return np.radians(float(self.parameters[name]))

    def hit(self, rays: camera.Rays) -> tuple[Array, Array]:
        """Return the distance along each ray, and whether it meets the rectangle."""
        inverse = np.linalg.inv(self.to_world)
        o = inverse[:3, :3] @ rays.origin + inverse[:3, 3]
        d = rays.direction @ inverse[:3, :3].T
        t = -o[2] / d[..., 2]
        u, v = o[0] + t * d[..., 0], o[1] + t * d[..., 1]
        return t, (t > 0) & (abs(u) <= 1) & (abs(v) <= 1)

    def mueller(self, rays: camera.Rays) -> Array:
        """Return the Mueller matrix [H,W,K,4,4] between the sensor frames of each ray."""
        # a sheared plate keeps U; V is square to it
        axis_u = camera.unit(self.to_world[:3, 0])
        normal = camera.unit(np.cross(axis_u, self.to_world[:3, 1]))
        axis_v = np.cross(normal, axis_u)
        k = -rays.direction
        if self.kind == "circular":
            left = self.parameters.get("left_handed") == "true"
            return np.broadcast_to(
                optics.circular_polarizer(-1 if left else 1), (*k.shape[:-1], 4, 4)
            )
        theta = self.degrees("theta")
        if self.kind == "polarizer":
            # effective axis: the absorbing axis projected across the ray
            absorbing = np.sin(theta) * axis_u + np.cos(theta) * axis_v
            passing = np.cross(k, absorbing)
            return optics.at_angle(optics.polarizer(), rays.angle_of(passing))
        # U projected across the ray, then theta counter-clockwise for who sees the front
        cos = camera.dot(k, np.broadcast_to(normal, k.shape))
        fast = rays.angle_of(axis_u - camera.dot(k, axis_u[None, None, None])[..., None] * k)
        fast = fast + np.sign(cos) * theta
        return optics.at_angle(optics.retarder(self.degrees("delta") * abs(cos)), fast)


def transform(node: ET.Element) -> Array:
    """Return the matrix of translate, rotate and scale in file order."""
    m = np.eye(4)
    for step in node:
        x, y, z = (
            float(step.get(c, step.get("value", 1.0 if step.tag == "scale" else 0.0)))
            for c in "xyz"
        )
        op = np.eye(4)
        if step.tag == "translate":
            op[:3, 3] = x, y, z
        elif step.tag == "scale":
            op[:3, :3] = np.diag([x, y, z])
        elif step.tag == "rotate":
            # as Mitsuba, which does not normalize the axis: (1, 1, 0) also stretches
            angle, axis = np.radians(float(step.get("angle", 0))), np.array([x, y, z])
            cos, sin = np.cos(angle), np.sin(angle)
            op[:3, :3] = cos * np.eye(3) + (1 - cos) * np.outer(axis, axis)
            op[:3, :3] += sin * np.cross(np.eye(3), axis)
        else:
            raise ValueError(f"unexpected <{step.tag}> in a transform")
        m = op @ m
    return m


def plates_of(scene: Path) -> tuple[list[Plate], float]:
    """Return the rectangles of a scene and the radiance behind them all."""
    root = ET.parse(scene).getroot()
    plates = []
    for shape in root.iter("shape"):
        if shape.get("type") != "rectangle":
            raise ValueError(f"unexpected shape '{shape.get('type')}'")
        node, bsdf = shape.find("transform"), shape.find("bsdf")
        assert node is not None and bsdf is not None, "every plate has a place and a bsdf"
        lamp = shape.find("emitter/spectrum")
        radiance = 0.0 if lamp is None else float(lamp.get("value", 1))
        parameters = {p.get("name", ""): p.get("value", "") for p in bsdf}
        plates.append(Plate(transform(node), bsdf.get("type", ""), parameters, radiance))
    sky = root.find("emitter[@type='constant']/spectrum")
    assert sky is not None, "the scenes have a constant environment"
    return plates, float(sky.get("value", 1))


def closed_form(name: str) -> tuple[Array, Array]:
    """Return the Stokes image [H,W,4,1], and how far its samples in and around a pixel spread."""
    view = VIEWS[name]
    rays = camera.look_at(view.origin, (0, 0, 0), view.fov_x, view.size, SUPERSAMPLES)
    plates, sky = plates_of(SCENES / name / "scene.xml")
    light = np.zeros((*rays.direction.shape[:-1], 4))
    light[..., 0] = sky
    # from the far plate to the near one; plates that overlap in the image do not cross
    for plate in sorted(plates, key=lambda p: -np.linalg.norm(p.to_world[:3, 3] - rays.origin)):
        _, meets = plate.hit(rays)
        if plate.radiance > 0:
            after = np.broadcast_to([plate.radiance, 0, 0, 0], light.shape)
        else:
            after = (plate.mueller(rays) @ light[..., None])[..., 0]
        light = np.where(meets[..., None], after, light)
    # an edge may pass between the border of a pixel and its outermost sample
    near = (3, 3, 1)
    spread = ndimage.maximum_filter(light.max(2), near) - ndimage.minimum_filter(light.min(2), near)
    return light.mean(2)[..., None], spread[..., None]


def main() -> int:
    """Render both scenes and compare."""
    parser = arguments(__doc__)
    parser.add_argument("--spp", type=int, default=64, help="samples a pixel (default 64)")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    report = Report("Polarizing plates, against Mueller calculus in numpy")
    for name, view in VIEWS.items():
        expected, spread = closed_form(name)
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "image.exr"
            size = f"{view.size[0]}x{view.size[1]}"
            options = ["--spp", str(args.spp), "--seed", str(args.seed), "--size", size]
            options += INDEPENDENT
            render(SCENES / name / "scene.xml", out, *options)
            image = read(out)
        # an edge lies between two samples in each of its pixels
        allowed = GEOMETRY + spread / SUPERSAMPLES
        report.same_image(name, image, expected, block=1, systematic=allowed)
        # the light still varies within a pixel: what six standard errors do not explain is left
        inside = spread.max((2, 3)) < 0.02
        beyond_noise = np.abs(image.mean - expected) - 6 * np.sqrt(image.variance)
        worst = beyond_noise[inside].max()
        report.within(f"{name}: difference beyond noise, away from edges", float(worst), 1e-4)
    return report.finish()


if __name__ == "__main__":
    sys.exit(main())
