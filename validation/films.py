"""Thin films seen through the whole program, against the package tmm and colour-science.

Each film is a `layered` rectangle that mirrors a lamp behind a polarizer at 45 degrees, so that
all of S0 … S3 tell of r_s and r_p; angle by angle and wavelength by wavelength.  Both packages
write fields as exp(−iωt): their amplitudes are conjugated.  colour-science knows clear media
only, and powers.
"""

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import colour.phenomena
import numpy as np
import tmm
from common import INDEPENDENT, Array, Report, arguments, read, render

ANGLES = (12.0, 40.0, 57.0, 75.0)
WAVELENGTHS = (430.0, 550.0, 680.0)
# directions in 32 bits, and phases of a few radians
ROUND_OFF = 1e-5


@dataclass
class Films:
    """Thicknesses in nm, and indices η − ik from the outside to the inside, without air."""

    name: str
    thicknesses: tuple[float, ...]
    indices: tuple[complex, ...]

    def bsdf(self) -> str:
        """Return the films as a scene file has them."""

        def text(n: complex) -> str:
            return f"{n.real}{n.imag:+}i" if n.imag else f"{n.real}"

        *films, inside = map(text, self.indices)
        thickness = ", ".join(f"{t}nm" for t in self.thicknesses)
        return (
            f'<bsdf type="layered"><string name="thickness" value="{thickness}"/>'
            f'<string name="ior" value="{", ".join(films)}"/>'
            f'<string name="int_ior" value="{inside}"/><float name="ext_ior" value="1"/></bsdf>'
        )


FILMS = (
    Films("soap", (320,), (1.33, 1)),
    Films("oxide on niobium", (110,), (2.3, 2.92 - 2.88j)),
    Films("coated lens", (99.6,), (1.38, 1.52)),
    Films("mirror of four layers", (60, 94, 60, 94), (2.3, 1.46, 2.3, 1.46, 1.52)),
    Films("gold leaf", (20,), (0.43 - 2.46j, 1)),
    Films("absorbing film on metal", (80,), (2.0 - 0.4j, 0.2 - 3.4j)),
)


def scene(films: Films, degrees: float) -> str:
    """Return a scene whose one pixel sees the lamp in the films."""
    sin, cos = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    look = 'target="0, 0, 0" up="0, 1, 0"'
    return f"""<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="4"/></integrator>
    <sensor type="perspective"><float name="fov" value="0.01"/>
        <transform name="to_world"><lookat origin="{4 * sin}, 0, {4 * cos}" {look}/></transform>
        <film type="hdrfilm"><integer name="width" value="1"/><integer name="height" value="1"/>
            <rfilter type="box"/></film></sensor>
    <shape type="rectangle">{films.bsdf()}</shape>
    <shape type="rectangle"><transform name="to_world"><scale value="0.1"/>
        <lookat origin="{-2 * sin}, 0, {2 * cos}" {look}/></transform>
        <bsdf type="polarizer"><float name="theta" value="45"/></bsdf></shape>
    <shape type="rectangle"><transform name="to_world"><scale value="0.1"/>
        <lookat origin="{-3 * sin}, 0, {3 * cos}" {look}/></transform>
        <emitter type="area"><float name="radiance" value="1"/></emitter></shape>
</scene>"""


def stokes(r_s: complex, r_p: complex) -> Array:
    """Return what the camera sees: light with E_s = E_p that was reflected."""
    product = r_s * np.conj(r_p)
    s = [abs(r_s) ** 2 + abs(r_p) ** 2, abs(r_s) ** 2 - abs(r_p) ** 2]
    # s is up in the image and p is left: S1 and S2 change sign
    return np.array([s[0], -s[1], -2 * product.real, -2 * product.imag]) / 4


def expected(films: Films, degrees: float, nm: float) -> Array:
    """Return the Stokes vector by tmm."""
    n = [1, *np.conj(films.indices)]
    d = [np.inf, *films.thicknesses, np.inf]
    r = [tmm.coh_tmm(p, n, d, np.radians(degrees), nm)["r"] for p in "sp"]
    return stokes(*np.conj(r))


def reflectances(films: Films, degrees: float, nm: float) -> Array:
    """Return R_s and R_p by colour-science."""
    n = np.array([1, *np.real(films.indices)])
    t = np.array(films.thicknesses, dtype=float)
    r, _ = colour.phenomena.multilayer_tmm(n, t, nm, degrees)
    return np.ravel(r)


def main() -> int:
    """Render every film at every angle and wavelength, and compare."""
    parser = arguments(__doc__)
    parser.add_argument("--spp", type=int, default=4096, help="samples a pixel (default 4096)")
    args = parser.parse_args()
    report = Report("Thin films, against tmm and colour-science")
    for films in FILMS:
        worst, worst_power = 0.0, 0.0
        clear = not np.any(np.imag(films.indices))
        for degrees in ANGLES:
            with tempfile.TemporaryDirectory() as folder:
                path, out = Path(folder) / "scene.xml", Path(folder) / "image.exr"
                path.write_text(scene(films, degrees))
                for nm in WAVELENGTHS:
                    options = ["--spp", str(args.spp), "--wavelength", f"{nm}nm"]
                    render(path, out, *options, *INDEPENDENT)
                    image = read(out)
                    mean, variance = image.mean[0, 0, :, 0], image.variance[0, 0, :, 0]
                    noise = 5 * np.sqrt(variance) + ROUND_OFF
                    off = np.abs(mean - expected(films, degrees, nm)) / noise
                    worst = max(worst, float(off.max()))
                    if clear:
                        power = np.sum(reflectances(films, degrees, nm)) / 4
                        worst_power = max(worst_power, abs(float(mean[0] - power)) / noise[0])
        report.within(f"{films.name}: S against tmm, over five standard errors", worst, 1.0)
        if clear:
            what = f"{films.name}: power against colour-science, over the same"
            report.within(what, worst_power, 1.0)
    return report.finish()


if __name__ == "__main__":
    sys.exit(main())
