"""The way from spectra to linear sRGB against colour-science's CIE 1931 data and sRGB matrix.

Renders tiny scenes with `--rgb`: a constant emitter with a unit, a tabulated, a D65 and an `rgb`
spectrum, and a sphere whose tabulated reflectance multiplies a tabulated emitter.  Tabulated
spectra are piecewise linear and zero outside; Y of the unit spectrum is 1.0010, i.e. XYZ are the
integrals over 360–830 nm divided by 106.7503 nm.  One more render, at one wavelength, must read
the tabulated value itself.

The mean over the image is tested by z, significance 1e-3 for all cases and colours together
(Šidák), beyond a systematic allowance of 1e-3 of Y for the four digits of the standard's matrix.
"""

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from colour import MSDS_CMFS, RGB_COLOURSPACES, SDS_ILLUMINANTS, SpectralDistribution
from common import Array, Image, Report, arguments, read, render, sidak_z

SIZE = 16
SAMPLED = np.arange(360.0, 831.0)
# ∫ȳ dλ = 106.857 nm over 360–830 nm; this divisor makes Y of the unit spectrum 1.0010
NORMALIZATION = 106.7502593994140625
SYSTEMATIC = 1e-3
SIGNIFICANCE = 1e-3

Table = dict[float, float]
UNIT: Table = {360.0: 1.0, 830.0: 1.0}
RAMP: Table = {400.0: 0.1, 700.0: 0.9}
NARROW: Table = {480.0: 0.0, 520.0: 2.0, 600.0: 0.5, 640.0: 0.0}
REDDISH: Table = {360.0: 0.05, 560.0: 0.1, 600.0: 0.7, 830.0: 0.6}

SCENE = """<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="2"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="20"/>
        <transform name="to_world"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform>
        <film type="hdrfilm">
            <integer name="width" value="{size}"/>
            <integer name="height" value="{size}"/>
            <string name="component_format" value="float32"/>
            <rfilter type="box"/>
        </film>
    </sensor>
    <emitter type="constant">{emitter}</emitter>
    {shapes}
</scene>
"""


@dataclass
class Case:
    """One render: what the file says, and the linear sRGB that must come out."""

    name: str
    emitter: str
    expected: Array
    shapes: str = ""


def at(table: Table, wavelengths: Array) -> Array:
    """Return a tabulated spectrum: piecewise linear, zero outside."""
    return np.interp(wavelengths, list(table), list(table.values()), left=0, right=0)


def pairs(name: str, table: Table) -> str:
    """Write a tabulated spectrum as the scene file has it."""
    text = ", ".join(f"{wavelength:g}:{value:.9g}" for wavelength, value in table.items())
    return f'<spectrum name="{name}" value="{text}"/>'


def to_srgb(spectrum: Array) -> Array:
    """Integrate a spectrum given at `SAMPLED` and convert it to linear sRGB."""
    cmfs = MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    matching = np.stack([np.interp(SAMPLED, cmfs.wavelengths, c) for c in cmfs.values.T], -1)
    xyz = np.trapezoid(spectrum[:, None] * matching, SAMPLED, axis=0) / NORMALIZATION
    return RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB @ xyz


def sphere(reflectance: Table) -> str:
    """Return a diffuse sphere that fills the view."""
    bsdf = f'<bsdf type="diffuse">{pairs("reflectance", reflectance)}</bsdf>'
    return f'<shape type="sphere">{bsdf}</shape>'


def cases() -> list[Case]:
    """Return everything that is rendered with `--rgb`."""
    d65: SpectralDistribution = SDS_ILLUMINANTS["D65"]
    white = {w: v / 100 for w, v in zip(d65.wavelengths, d65.values, strict=True)}
    white = {float(w): float(v) for w, v in white.items() if 360 <= w <= 830}
    made = [
        Case(name, pairs("radiance", table), to_srgb(at(table, SAMPLED)))
        for name, table in (
            ("unit spectrum, tabulated", UNIT),
            ("ramp", RAMP),
            ("narrow", NARROW),
            ("D65, tabulated", white),
        )
    ]
    plain = '<spectrum name="radiance" value="1"/>'
    grey = '<rgb name="radiance" value="1, 1, 1"/>'
    orange = '<rgb name="radiance" value="0.8, 0.5, 0.3"/>'
    product = to_srgb(at(RAMP, SAMPLED) * at(REDDISH, SAMPLED))
    return [
        Case("unit spectrum, one number", plain, to_srgb(np.ones_like(SAMPLED))),
        *made,
        Case("rgb 1, 1, 1", grey, np.ones(3)),
        Case("rgb 0.8, 0.5, 0.3", orange, np.array([0.8, 0.5, 0.3])),
        Case("sphere: reflectance × ramp", pairs("radiance", RAMP), product, sphere(REDDISH)),
    ]


def rendered(folder: Path, case: Case, *options: str) -> Image:
    """Render a case and read the image."""
    scene, out = folder / "scene.xml", folder / "image.exr"
    scene.write_text(SCENE.format(size=SIZE, emitter=case.emitter, shapes=case.shapes))
    render(scene, out, *options)
    return read(out)


def main() -> int:
    """Render every case and compare."""
    parser = arguments(__doc__)
    parser.add_argument("--spp", type=int, default=2048, help="samples a pixel (default 2048)")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    report = Report("Spectra to linear sRGB, against colour-science")
    unit_y = RGB_COLOURSPACES["sRGB"].matrix_RGB_to_XYZ[1] @ to_srgb(np.ones_like(SAMPLED))
    report.within("|Y of the unit spectrum − 1.0010|", abs(float(unit_y) - 1.0010), 1e-4)
    everything = cases()
    limit = sidak_z(SIGNIFICANCE, 3 * len(everything))
    with tempfile.TemporaryDirectory() as folder:
        for case in everything:
            options = ["--rgb", "--spp", str(args.spp), "--seed", str(args.seed)]
            image = rendered(Path(folder), case, *options)
            mean = image.mean[:, :, 0].mean((0, 1))
            sigma = np.sqrt(image.variance[:, :, 0].sum((0, 1))) / SIZE**2
            luminance = RGB_COLOURSPACES["sRGB"].matrix_RGB_to_XYZ[1] @ case.expected
            excess = np.maximum(abs(mean - case.expected) - SYSTEMATIC * luminance, 0)
            # a grey spectrum has no noise: nothing is in excess of none
            z = np.divide(excess, sigma, out=np.where(excess > 0, np.inf, 0.0), where=sigma > 0)
            report.within(f"{case.name}: largest |z| of a colour", float(z.max()), limit)
            polarized = np.abs(image.mean[:, :, 1:]).max()
            report.within(f"{case.name}: S1, S2, S3", float(polarized), 0.0)
            report.within(f"{case.name}: noise / Y", float(sigma.max() / luminance), 5e-3)
        ramp = Case("ramp", pairs("radiance", RAMP), np.zeros(1))
        at_550 = rendered(Path(folder), ramp, "--wavelength", "550nm", "--spp", "4").mean[:, :, 0]
        report.within("ramp at 550 nm, |S0 − 0.5|", float(np.abs(at_550 - 0.5).max()), 1e-6)
    return report.finish()


if __name__ == "__main__":
    sys.exit(main())
