"""The extremes that `stress_images.py` renders: what each must be, how far it may be off.

ε is 2⁻²⁴, the rounding of a 32-bit number.  Of twins, which take the same paths of the same seed, a
contribution is a product over at most 8 vertices of about 30 roundings each: two of them differ by
TWIN = 2 · 8 · 30 ε.  A path that rounding moves across an edge, or over a choice, differs in full.
A hit is known to 4 ε of the box, widened FOCUS times by a curved smooth surface; edges are some 10
lengths in an area.  Of SAMPLES paths of 8 vertices

    MOVED = SAMPLES · 8 · 10 · 4 ε · FOCUS

pixels are expected to differ, and 5 standard deviations of that count more are allowed.  In a box
of mirrors a hit within 4 ε of an edge may miss the other wall: of as many hits a path may be lost
then, with the rest of its light.  A matt direction is drawn from two numbers of 24 bits; if either
is 0 the direction lies in the surface, and the path ends.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import stress_scenes as scenes
from common import INDEPENDENT, ROUND_OFF, Array, Image, Report, sidak_z
from optics import from_amplitudes, reflection_amplitudes

EPSILON = 2.0**-24
TWIN = 2 * 8 * 30 * EPSILON
FOCUS = 10
MOVED = scenes.SAMPLES * 8 * 10 * 4 * EPSILON * FOCUS
# roundings that the components of a Stokes vector go through at one vertex: a 4×4 matrix, two turns
VERTEX = 8
SIGNIFICANCE = 1e-3
BLOCK = 8

Options = tuple[str, ...]
Shoot = Callable[..., Image]


@dataclass
class Judge:
    """Renders and notes; `shoot` counts what is not finite."""

    shoot: Shoot
    report: Report

    def twin(self, what: str, image: Image, other: Image, factor: float = 1) -> None:
        """Hold an image to be `factor` times the other, path by path, and its variance too."""
        level = float(other.mean[:, :, 0].mean())
        difference = image.mean / factor - other.mean
        size = np.abs(difference) / np.maximum(np.abs(other.mean[:, :, :1]), 1e-3 * level)
        pixels = size[:, :, 0, 0].size
        allowed = MOVED + 5 * np.sqrt(MOVED / pixels)
        moved = float((size > TWIN).any((2, 3)).mean())
        self.report.within(
            f"{what}: median difference of S0", float(np.median(size[:, :, 0])), TWIN
        )
        self.report.within(f"{what}: share of pixels that differ", moved, allowed)
        drift = np.abs(difference.mean((0, 1))) - TWIN * level
        noise = difference.std((0, 1)) / np.sqrt(pixels) + EPSILON * level
        z = float((np.maximum(drift, 0) / noise).max())
        self.report.within(f"{what}: |z| of the drift", z, sidak_z(SIGNIFICANCE, 4))
        stated = [float(np.median(i.variance[:, :, 0])) for i in (image, other)]
        if stated[1] > 0:
            # pixels that differ move the median by as many ranks, of variances over some decades
            off = abs(stated[0] / factor**2 / stated[1] - 1)
            self.report.within(f"{what}: median variance", off, 10 * allowed)

    def number(self, what: str, value: Array | float, expected: Array | float, off: float) -> None:
        """Hold numbers to a closed form."""
        error = float(np.max(np.abs(np.asarray(value) - np.asarray(expected))))
        self.report.within(what, error, off)


def sizes(judge: Judge) -> None:
    """Scale a box with glass, metal and a lamp: the picture is the same one."""
    plain = judge.shoot(scenes.box())
    for scale in (1e-6, 1e-3, 1e3, 1e6):
        judge.twin(f"size {scale:g}", judge.shoot(scenes.box(scale=scale)), plain)


def lamps(judge: Judge) -> None:
    """Strengthen and weaken the lamp, and put a strong one behind the walls of a weak one."""
    plain = judge.shoot(scenes.box())
    for factor in (1e-12, 1e12):
        image = judge.shoot(scenes.box(radiance=10 * factor))
        judge.twin(f"lamp × {factor:g}", image, plain, factor)
    alone = judge.shoot(scenes.two_rooms(1e-12, 0))
    beside = judge.shoot(scenes.two_rooms(1e-12, 1e12), "--seed", "7")
    judge.report.same_image(
        "1e-12 beside 1e12",
        Image(beside.mean, beside.variance + alone.variance),
        alone.mean,
        block=BLOCK,
    )


def wavelengths(judge: Judge) -> None:
    """Go from 200 nm to 1 mm: plain numbers do not change, matter that scales along neither."""
    plain = judge.shoot(scenes.box())
    for nm in (200.0, 1e6):
        image = judge.shoot(scenes.box(), "--wavelength", f"{nm:g}nm")
        worst = float(np.abs(image.mean - plain.mean).max())
        judge.report.within(f"{nm:g} nm: difference where nothing depends on it", worst, 0.0)
    for name, bsdf in WAVE_MATTER.items():
        usual = judge.shoot(scenes.plate(bsdf(550e-9), 40), "--wavelength", "550nm")
        for nm in (200.0, LONGEST.get(name, 1e6)):
            image = judge.shoot(scenes.plate(bsdf(nm * 1e-9), 40), "--wavelength", f"{nm:g}nm")
            judge.twin(f"{name} at {nm:g} nm", image, usual)
    for nm in (200.0, 550.0, 1e6):
        # a quarter-wave film on metal at normal incidence
        image = judge.shoot(scenes.plate(film(nm * 1e-9), 1e-3), "--wavelength", f"{nm:g}nm")
        outer, inner = (1 - 1.38) / (1 + 1.38), (1.38 - SUBSTRATE) / (1.38 + SUBSTRATE)
        reflected = abs((outer - inner) / (1 - outer * inner)) ** 2
        judge.number(f"quarter wave at {nm:g} nm: S0", image.mean[:, :, 0], reflected, TWIN)


def length(name: str, metres: float) -> str:
    """Return a parameter in metres."""
    return f'<float name="{name}" value="{metres!r}"/>'


METAL = '<spectrum name="eta" value="0.2"/><spectrum name="k" value="3.2"/>'


# index of the metal, η − ik
SUBSTRATE = 0.2 - 3.2j


def film(wavelength: float) -> str:
    """Return a film on metal, a quarter of the wavelength thick."""
    thickness = f'<string name="thickness" value="{wavelength / 4 / 1.38 * 1e9:.9g}nm"/>'
    return f"""<bsdf type="layered">{thickness}<string name="ior" value="1.38"/>
        <string name="int_ior" value="0.2-3.2i"/><float name="ext_ior" value="1"/></bsdf>"""


WAVE_MATTER: dict[str, Callable[[float], str]] = {
    "film": film,
    "rough surface": lambda w: (
        f'<bsdf type="roughsurface">{length("height", 0.08 * w)}{length("length", 9 * w)}'
        f"{METAL}</bsdf>"
    ),
    "grating": lambda w: (
        f'<bsdf type="grating">{length("pitch", 7 * w)}{length("depth", 0.3 * w)}{METAL}</bsdf>'
    ),
    "fine grating": lambda w: (
        f'<bsdf type="grating">{length("pitch", 0.9 * w)}{length("depth", 0.1 * w)}{METAL}</bsdf>'
    ),
}


# nm; gratings have pitches up to 1 mm, this one of seven wavelengths
LONGEST = {"grating": 1e5}


def long_paths(judge: Judge) -> None:
    """Follow light over 1000 bounces that lose nothing."""
    bounces = 1000
    drift = (VERTEX / 2 + 0.5) * bounces * EPSILON
    paths = scenes.SIZE**2 * scenes.SAMPLES
    # of mirrors: 8 edges' length on the area of 4 of a wall, 4 ε wide; of matt: ε for each number
    per_bounce = {"mirrors": 2 * 4 * EPSILON, "points of a white sphere": 2 * EPSILON}
    for what, text in (
        ("mirrors", scenes.mirror_box(bounces + 1)),
        ("points of a white sphere", scenes.white_sphere(bounces + 1)),
    ):
        lost = paths * bounces * per_bounce[what]
        share = (lost + 5 * np.sqrt(lost)) / paths
        for points, sampler in (("", INDEPENDENT), (", Sobol' points", ())):
            relative = judge.shoot(text, sampler=sampler).mean[..., 0] / (bounces + 1)
            energy = relative[..., 0]
            name = f"1001 shining {what}{points}"
            judge.number(f"{name}: S0/1001 of the median", np.median(energy), 1, drift)
            judge.number(f"{name}: S0/1001 of the brightest", energy.max(), 1, drift)
            judge.number(f"{name}: S0/1001 of the mean", energy.mean(), 1, drift + share)
            judge.number(f"{name}: S1…S3", relative[..., 1:], 0, drift)

    state = (0.1, 0.6, 0.3)
    image = judge.shoot(scenes.corridor(bounces, state))
    r_s, r_p = reflection_amplitudes(1, -1j, np.sqrt(0.5))
    matrix = np.linalg.matrix_power(from_amplitudes(r_s, r_p), bounces)
    expected = matrix @ [1.0, *state]
    found = image.mean[..., 0]
    # beside rounding at each mirror: the retardance of a direction that is off by 2 ε
    off = bounces * EPSILON * (VERTEX + 2)
    polarized = [np.linalg.norm(s[..., 1:], axis=-1) / s[..., 0] for s in (found, expected)]
    judge.number("1000 retarding mirrors: S0", found[..., 0], 1, off)
    judge.number("1000 retarding mirrors: S", found, expected, off)
    judge.number("1000 retarding mirrors: polarization", *polarized, off)


def slivers(judge: Judge) -> None:
    """Look at triangles of a million to one, and light with them."""
    strips, width = 50, 2e-6
    for angle in (0.0, 37.0):
        mesh = scenes.sliver_mesh(strips, width, frame=True)
        image = judge.shoot(scenes.sliver_wall(width, strips, angle), mesh=mesh)
        judge.number(f"black slivers turned {angle:g}°: light through", image.mean, 0, 0.0)
    strips = 40
    grow = scenes.vector("scale", (strips * width / 2, 1, 1))
    radiance = 1 / (strips * width)
    shape = '<shape type="{}">{}'
    mesh = shape.format("obj", '<string name="filename" value="mesh.obj"/>')
    lit = judge.shoot(
        scenes.sliver_lamp(mesh, radiance).format(""),
        mesh=scenes.sliver_mesh(strips, width, frame=False),
    )
    twin = scenes.sliver_lamp(shape.format("rectangle", ""), radiance).format(grow)
    other = judge.shoot(twin, "--seed", "7")
    image = Image(lit.mean, lit.variance + other.variance)
    judge.report.same_image("sliver lamp", image, other.mean, block=BLOCK)


def grazing(judge: Judge) -> None:
    """Mirror the sky in metal down to 1e-6 from the plane; and roughness down to nothing."""
    for angle in (1e-1, 1e-2, 1e-4, 1e-6):
        image = judge.shoot(scenes.mirror_floor(scenes.METAL, angle))
        cos = np.sin(angle) + np.array([0, 2 * EPSILON])
        matrix = from_amplitudes(*reflection_amplitudes(1, 0.2 - 3.2j, cos))
        # seen with the plane's normal up, s is image right
        expected = matrix[0, :, 0]
        off = 2 * np.abs(matrix[1, :, 0] - expected).max() + ROUND_OFF
        judge.number(f"metal at {angle:g} rad: S", image.mean[0, 0, :, 0], expected, off)
    smooth = judge.shoot(scenes.plate(scenes.METAL, 60))
    for alpha in (1e-2, 1e-3, 1e-4, 1e-6):
        rough = f'<bsdf type="roughconductor">{METAL}<float name="alpha" value="{alpha!r}"/></bsdf>'
        image = judge.shoot(scenes.plate(rough, 60))
        # facets at a mean square slope alpha², Fresnel's and Smith's terms of second order
        judge.report.same_image(
            f"alpha {alpha:g} beside smooth",
            image,
            smooth.mean,
            block=BLOCK,
            systematic=10 * alpha**2 + TWIN,
        )


CASES: dict[str, Callable[[Judge], None]] = {
    "sizes": sizes,
    "lamps": lamps,
    "wavelengths": wavelengths,
    "long_paths": long_paths,
    "slivers": slivers,
    "grazing": grazing,
}


def chosen(names: list[str]) -> Iterator[tuple[str, Callable[[Judge], None]]]:
    """Return the cases of these names, or all."""
    return ((name, case) for name, case in CASES.items() if not names or name in names)
