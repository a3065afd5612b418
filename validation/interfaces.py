"""Brewster's interface matrices against colour-science and against Fresnel in numpy.

Reads the CSV that `cargo run -q -p mueller16 --example interface_table` prints:

    n1,n2,k2,angle_deg,kind,m00,m01,…,m33

with the index n2 − i k2 (or n2 + i k2 at exp(−iωt)) behind the interface and kind R or T; T is
scaled to power.  numpy checks every row; colour-science, whose angles are real, those where light
is refracted at a real angle, i.e. all but total reflection and metals at oblique incidence.
"""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import optics
from colour.phenomena import (
    polarised_light_reflection_amplitude,
    polarised_light_transmission_amplitude,
    snell_law,
)
from common import ROOT, Array, Report, arguments, give_up

# absolute, of matrices whose elements are at most 1; both sides compute in 64 bits
TOLERANCE = 1e-12
COLUMNS = ["n1", "n2", "k2", "angle_deg", "kind", *(f"m{i}{j}" for i in range(4) for j in range(4))]
TABLE_COMMAND = ["cargo", "run", "-q", "-p", "mueller16", "--example", "interface_table"]
# what the table must hold to be worth checking
EXPECTED_CASES = ("external", "internal", "total reflection", "metal")


def numpy_matrix(n1: float, n2: complex, degrees: float, kind: str) -> Array:
    """Return the Mueller matrix by Fresnel's formulas."""
    cos = np.cos(np.radians(degrees))
    amplitudes = optics.reflection_amplitudes if kind == "R" else optics.transmission_amplitudes
    return optics.from_amplitudes(*amplitudes(n1, n2, cos))


def colour_matrix(n1: float, n2: complex, degrees: float, kind: str) -> Array | None:
    """Return the Mueller matrix by colour-science, or None where its angles do not reach."""
    with np.errstate(invalid="ignore"):
        refracted = float(snell_law(n1, n2, degrees))
    if not np.isfinite(refracted) or (n2.imag != 0 and degrees != 0):
        return None
    if kind == "R":
        r_s, r_p = polarised_light_reflection_amplitude(n1, n2, degrees, refracted)
        # there r_p = +r_s at normal incidence
        return optics.from_amplitudes(r_s, -r_p)
    t = polarised_light_transmission_amplitude(n1, n2, degrees, refracted)
    cos_ratio = np.cos(np.radians(refracted)) / np.cos(np.radians(degrees))
    return optics.from_amplitudes(*(t * np.sqrt(n2.real / n1 * cos_ratio)))


def case(n1: float, n2: complex, degrees: float) -> str:
    """Name what kind of interface a row is about."""
    if n2.imag != 0:
        return "metal"
    if n1 < n2.real:
        return "external"
    return "internal" if n1 * np.sin(np.radians(degrees)) < n2.real else "total reflection"


def main() -> int:
    """Compare the table row by row."""
    parser = arguments(__doc__)
    parser.add_argument("--table", type=Path, help="read this CSV instead of running the example")
    args = parser.parse_args()
    if args.table:
        text = args.table.read_text()
    else:
        run = subprocess.run(TABLE_COMMAND, cwd=ROOT, check=True, text=True, stdout=subprocess.PIPE)
        text = run.stdout
    lines = csv.DictReader(line for line in text.splitlines() if not line.startswith("#"))
    if lines.fieldnames != COLUMNS:
        give_up(f"columns are {lines.fieldnames}, expected {COLUMNS}")

    worst: dict[str, list[float]] = {}
    for line in lines:
        n1, degrees, kind = float(line["n1"]), float(line["angle_deg"]), line["kind"]
        n2 = complex(float(line["n2"]), -float(line["k2"]))
        ours = np.array([float(line[c]) for c in COLUMNS[5:]]).reshape(4, 4)
        name = f"{case(n1, n2, degrees)} {kind}"
        for who, theirs in (
            ("numpy", numpy_matrix(n1, n2, degrees, kind)),
            ("colour-science", colour_matrix(n1, n2, degrees, kind)),
        ):
            if theirs is not None:
                difference = np.abs(ours - theirs).max()
                worst.setdefault(f"{name}, {who}", []).append(float(difference))

    report = Report("Interface matrices (largest difference of an element)")
    for name, differences in sorted(worst.items()):
        report.within(f"{name} ({len(differences)} rows)", float(np.max(differences)), TOLERANCE)
    missing = [c for c in EXPECTED_CASES if not any(name.startswith(c) for name in worst)]
    report.within(
        f"kinds of interface the table lacks: {', '.join(missing) or 'none'}", len(missing), 0
    )
    return report.finish()


if __name__ == "__main__":
    sys.exit(main())
