"""Values of the covariant Hermite-Gauss family and its dual, by explicit sums in 400 digits.

    python3 validation/covariant.py          compares the tests' covariant.csv with new sums
    python3 validation/covariant.py --write  writes that file

The coefficient of a₁ⁿ a₂ᵐ in exp(2a·u − a'Ga) is added up term by term, without the recurrence that
the crate uses; the value at 0 is the same sum with u = 0, not (S1.7).  Inputs are the binary64
numbers that the file names.  `transform` is the Fourier transform divided by (−i)^(n+m).
"""

import argparse
import csv
import math
import random
import sys
from dataclasses import dataclass
from pathlib import Path

import mpmath as mp

FILE = Path(__file__).resolve().parent.parent / "crates/stokes/tests/data/covariant.csv"
HEADER = ["family", "n", "m", "theta11", "theta12", "theta22", "x1", "x2", "value"]
HEADER += ["zeta1", "zeta2", "transform", "zero"]
# what f64 can hold with room to spare
LARGEST, SMALLEST = 1e300, 1e-290
ORDERS = [(40, 40), (40, 0), (0, 40), (17, 23), (1, 39), (25, 25), (6, 3), (2, 1), (1, 0), (0, 0)]

mp.mp.dps = 400


@dataclass
class Case:
    """One function, a point and a frequency."""

    dual: bool
    n: int
    m: int
    theta: tuple[float, float, float]
    x: tuple[float, float]
    zeta: tuple[float, float]


def coefficient(n: int, m: int, u: list[mp.mpf], g: list[mp.mpf]) -> mp.mpf:
    """Return √(n! m!)/2^((n+m)/2) times the coefficient of a₁ⁿ a₂ᵐ in exp(2a·u − a'Ga)."""
    f = mp.factorial
    total = mp.mpf(0)
    for q in range(min(n, m) + 1):
        across = (-2 * g[1]) ** q / f(q)
        first = sum(
            (-g[0]) ** p / f(p) * (2 * u[0]) ** (n - q - 2 * p) / f(n - q - 2 * p)
            for p in range((n - q) // 2 + 1)
        )
        second = sum(
            (-g[2]) ** p / f(p) * (2 * u[1]) ** (m - q - 2 * p) / f(m - q - 2 * p)
            for p in range((m - q) // 2 + 1)
        )
        total += across * first * second
    return total * mp.sqrt(f(n) * f(m) / mp.mpf(2) ** (n + m))


def values(case: Case) -> list[mp.mpf]:
    """Return the function at x, its transform at ζ over (−i)^(n+m), and the function at 0."""
    t = [mp.mpf(entry) for entry in case.theta]
    x, zeta = [mp.mpf(v) for v in case.x], [mp.mpf(v) for v in case.zeta]
    det = t[0] * t[2] - t[1] ** 2
    inverse = [t[2] / det, -t[1] / det, t[0] / det]

    def times(a: list[mp.mpf], v: list[mp.mpf]) -> list[mp.mpf]:
        return [a[0] * v[0] + a[1] * v[1], a[1] * v[0] + a[2] * v[1]]

    def gaussian(a: list[mp.mpf], v: list[mp.mpf]) -> mp.mpf:
        w = times(a, v)
        return mp.exp(-(v[0] * w[0] + v[1] * w[1]) / 2) / mp.sqrt(mp.pi)

    norm = det ** mp.mpf("0.25")
    g = t if case.dual else inverse
    u = x if case.dual else times(inverse, x)
    value = gaussian(inverse, x) / norm * coefficient(case.n, case.m, u, g)
    zero = coefficient(case.n, case.m, [mp.mpf(0)] * 2, g) / mp.sqrt(mp.pi) / norm
    # the other family with Θ⁻¹: its u is Θζ or ζ, its quadratic form is again g
    u = times(t, zeta) if case.dual else zeta
    transform = 2 * mp.pi * norm * gaussian(t, zeta) * coefficient(case.n, case.m, u, g)
    return [value, transform, zero]


def cases() -> list[Case]:
    """Return all kinds of shapes, from round to a line, in units from 1e-8 to 1e8."""
    rng = random.Random(20210401)
    found = []
    for scale in (1.0, 1e-8, 1e8):
        for condition in (1.0, 1e2, 1e4, 1e6, 1e10, 1e14):
            for k in range(4):
                n, m = ORDERS[len(found) % len(ORDERS)]
                if k == 3:
                    n, m = rng.randint(0, 40), rng.randint(0, 40)
                angle = rng.choice([0.0, rng.uniform(0, math.pi)])
                wide, thin = scale * condition**0.5, scale / condition**0.5
                c, s = math.cos(angle), math.sin(angle)
                across = c * s * (wide - thin)
                theta = (c * c * wide + s * s * thin, across, s * s * wide + c * c * thin)
                r, turn = rng.choice([1e-3, 0.7, 3.0, 8.0]), rng.uniform(0, 2 * math.pi)
                y = (r * math.cos(turn), r * math.sin(turn))
                a, b = wide**0.5 * y[0], thin**0.5 * y[1]
                x = (c * a - s * b, s * a + c * b)
                a, b = y[0] / wide**0.5, y[1] / thin**0.5
                case = Case(k % 2 == 1, n, m, theta, x, (c * a - s * b, s * a + c * b))
                while any(v and not SMALLEST < abs(v) < LARGEST for v in values(case)):
                    case.n, case.m = case.n // 2, case.m // 2
                found.append(case)
    return found


def rows() -> list[list[str]]:
    """Return the lines of the table."""
    table = []
    for case in cases():
        value, transform, zero = (repr(float(v)) for v in values(case))
        head = ["dual" if case.dual else "covariant", str(case.n), str(case.m)]
        numbers = [*case.theta, *case.x]
        head += [repr(v) for v in numbers] + [value] + [repr(v) for v in case.zeta]
        table.append([*head, transform, zero])
    return table


def main() -> int:
    """Write the file, or compare it with what would be written."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--write", action="store_true")
    made = ["# made by validation/covariant.py: explicit sums in 400 digits"]
    table = [made, HEADER, *rows()]
    if parser.parse_args().write:
        with FILE.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(table)
        return 0
    with FILE.open(newline="") as file:
        same = list(csv.reader(file)) == table
    print("covariant.csv:", "as computed" if same else "differs")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
