"""Writes data/cie/cie1931_2deg_d65.csv: the CIE tables that the renderer is built with.

    validation/.venv/bin/python validation/make_cie_tables.py

Colour matching functions of the CIE 1931 2 degree standard observer at 1 nm, and illuminant D65,
both from the CIE's tables in colour-science. The D65 table there ends at 780 nm; the CIE's
daylight formula, which agrees with the table within 0.001, continues it to 830 nm. D65 is given
every 5 nm and interpolated linearly, as CIE 15 asks.
"""

from pathlib import Path

import colour
import numpy as np

FIRST, LAST = 360, 830
TARGET = Path(__file__).resolve().parent.parent / "data" / "cie" / "cie1931_2deg_d65.csv"


def d65() -> np.ndarray:
    """Relative power of D65 at FIRST..=LAST nm in steps of 1 nm, 100 at 560 nm."""
    xy = colour.temperature.CCT_to_xy_CIE_D(6500 * 1.4388 / 1.4380)
    formula = colour.sd_CIE_illuminant_D_series(xy)
    table = colour.SDS_ILLUMINANTS["D65"]
    shared = table.wavelengths
    worst = np.max(np.abs(formula[shared] - table.values))
    if worst > 1e-3:
        raise SystemExit(f"the daylight formula misses the table of D65 by {worst}")
    knots = np.arange(FIRST, LAST + 5, 5)
    values = np.where(knots <= 780, np.interp(knots, shared, table.values), formula[knots])
    return np.interp(np.arange(FIRST, LAST + 1), knots, values)


def main() -> None:
    """Write the table."""
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    rows = np.arange(FIRST, LAST + 1)
    xyz = observer[rows]
    lines = [
        f"# made by validation/make_cie_tables.py with colour-science {colour.__version__} "
        "from the CIE's tables (CIE 1931 2 degree observer; illuminant D65, daylight formula "
        "beyond 780 nm)",
        "wavelength_nm,x,y,z,d65",
    ]
    for wavelength, (x, y, z), power in zip(rows, xyz, d65(), strict=True):
        lines.append(f"{wavelength},{x:.12g},{y:.12g},{z:.12g},{power:.8g}")
    TARGET.parent.mkdir(parents=True, exist_ok=True)
    TARGET.write_text("\n".join(lines) + "\n")
    print(f"{TARGET}: {len(rows)} rows")


if __name__ == "__main__":
    main()
