"""Hermite-Gauss functions from their definitions: numpy for quadrature, mpmath for many digits.

    Σ (√2 s)ⁿ/√n! h_n(t) = π^(-1/4) exp(−t²/2 + 2st − s²)
    Σ 2^((n+m)/2)/√(n!m!) a1ⁿ a2ᵐ Ψ_nm(x) = exp(−x'Θ⁻¹x/2 + a'Θ⁻¹(2x − a)) / (π^½ |Θ|^¼)
    Σ 2^((n+m)/2)/√(n!m!) a1ⁿ a2ᵐ Ψ̃_nm(x) = exp(−x'Θ⁻¹x/2 + a'(2x − Θa)) / (π^½ |Θ|^¼)

Everything below follows from these three lines by contour integrals, by differentiation or by
integration of Gaussians.
"""

from collections.abc import Sequence
from functools import cache
from itertools import product
from math import isqrt
from typing import Any

import numpy as np
from common import Array
from mpmath import mp
from scipy.special import factorial

Matrix = Sequence[Sequence[Any]]
Table = dict[tuple[int, ...], Any]

# ---------------------------------------------------------------- numpy


def hermite_table(order: int, t: Array) -> Array:
    """Return h_0 … h_order at `t`, along a new first axis; for |t| < 37."""
    table = np.empty((order + 1, *np.shape(t)))
    table[0] = np.pi**-0.25 * np.exp(-0.5 * np.square(t))
    if order > 0:
        table[1] = np.sqrt(2) * t * table[0]
    for n in range(1, order):
        table[n + 1] = np.sqrt(2 / (n + 1)) * t * table[n] - np.sqrt(n / (n + 1)) * table[n - 1]
    return table


def from_generating_function(
    order: int, theta: Array, x: Array, *, dual: bool, radius: float = 0.8, points: int = 64
) -> tuple[Array, Array]:
    """Return Ψ_nm(x) or its dual for n, m ≤ order by Cauchy's integral over two circles.

    The trapezoid rule on circles converges faster than any power.  `radius` is in units of
    1/√diag(Θ⁻¹), of the dual 1/√diag(Θ).  The second table is the largest integrand: the first
    is right to a few roundings of it.
    """
    inverse = np.linalg.inv(theta)
    u, g = (x, theta) if dual else (inverse @ x, inverse)
    scale = radius / np.sqrt(np.diag(g))
    circle = np.exp(2j * np.pi * np.arange(points) / points)
    a = np.stack(np.meshgrid(scale[0] * circle, scale[1] * circle, indexing="ij"))
    exponent = 2 * np.einsum("i...,i->...", a, u) - np.einsum("i...,ij,j...", a, g, a)
    start = np.exp(-0.5 * x @ inverse @ x) / (np.sqrt(np.pi) * np.linalg.det(theta) ** 0.25)
    integrand = start * np.exp(exponent)
    n = np.arange(order + 1)
    weight = np.sqrt(factorial(n) / 2.0**n)
    weights = np.outer(weight / scale[0] ** n, weight / scale[1] ** n)
    table = np.fft.fft2(integrand)[: order + 1, : order + 1].real / points**2
    return table * weights, np.abs(integrand).max() * weights


# --------------------------------------------------------------- mpmath


def exact(values: Any) -> Any:  # noqa: ANN401
    """Return nested lists of 64-bit numbers as the mpmath numbers they are."""
    if isinstance(values, list | tuple | np.ndarray):
        return [exact(value) for value in values]
    return mp.mpmathify(values if isinstance(values, int | complex) else float(values))


@cache
def _steps(order: int, bits: int) -> list[tuple[int, int]]:
    """Return √(2/(n+1)) and √(n/(n+1)) for n < `order`, in units of 2^-bits."""
    one = 1 << 2 * bits
    return [(isqrt(2 * one // (n + 1)), isqrt(n * one // (n + 1))) for n in range(order)]


class HermiteDigits:
    """h_0(t) … h_order(t) to 60 digits of their envelope, for any `t`; `h[n]` is an mpmath number.

    The recurrence runs in fixed-point integers on h_n/h_0, whose envelope is never small.
    """

    def __init__(self, order: int, t: Any) -> None:  # noqa: ANN401
        """Run the recurrence up to `order`."""
        # a tiny argument needs its own leading digits
        self.bits = 240 + max(0, -int(mp.mag(t)) if t else 0)
        self.start = mp.exp(-t * t / 2) / mp.root(mp.pi, 4)
        argument, bits = int(mp.ldexp(t, self.bits)), self.bits
        before, now = 0, 1 << bits
        self.ratios = [now]
        for up, down in _steps(order, bits):
            before, now = now, (((up * argument) >> bits) * now - down * before) >> bits
            self.ratios.append(now)

    def __getitem__(self, n: int) -> Any:  # noqa: ANN401
        """Return h_n(t)."""
        return self.start * mp.ldexp(self.ratios[n], -self.bits)


def slope(n: int, t: Any, values: HermiteDigits) -> Any:  # noqa: ANN401
    """Return h_n'(t) = √(2n) h_{n−1} − t h_n."""
    below = mp.sqrt(2 * n) * values[n - 1] if n else 0
    return below - t * values[n]


def determinant(m: Matrix) -> Any:  # noqa: ANN401
    """Return the determinant of a 2×2 matrix."""
    return m[0][0] * m[1][1] - m[0][1] * m[1][0]


def inverse(m: Matrix) -> list[list[Any]]:
    """Return the inverse of a 2×2 matrix."""
    d = determinant(m)
    return [[m[1][1] / d, -m[0][1] / d], [-m[1][0] / d, m[0][0] / d]]


def apply(m: Matrix, v: Sequence[Any]) -> list[Any]:
    """Return m v."""
    return [row[0] * v[0] + row[1] * v[1] for row in m]


def matmul(a: Matrix, b: Matrix) -> list[list[Any]]:
    """Return a b, of 2×2 matrices."""
    return [[row[0] * b[0][j] + row[1] * b[1][j] for j in (0, 1)] for row in a]


def transpose(m: Matrix) -> list[list[Any]]:
    """Return the transpose."""
    return [list(column) for column in zip(*m, strict=True)]


def covariant_table(
    order: int,
    theta: Matrix,
    x: Sequence[Any],
    *,
    dual: bool,
    most: tuple[int, int] | None = None,
) -> Table:
    """Return Ψ_nm(x) or its dual for n + m ≤ order, n and m up to `most`.

    ∂/∂a1 of the generating function gives the orders one by one.
    """
    g = theta if dual else inverse(theta)
    u = x if dual else apply(g, x)
    y = apply(inverse(theta), x)
    start = mp.exp(-(x[0] * y[0] + x[1] * y[1]) / 2)
    table = {(0, 0): start / (mp.sqrt(mp.pi) * mp.root(determinant(theta), 4))}
    root = [mp.sqrt(n) for n in range(order + 2)]
    first, second = most or (order, order)
    for n, m in list(product(range(first + 1), range(second + 1)))[1:]:
        if n + m > order:
            continue
        axis, p, q = (0, n - 1, m) if n else (1, m - 1, n)
        # one order less along `axis`; the other axis holds q
        at = (lambda i, j: (i, j)) if n else (lambda i, j: (j, i))
        value = root[2] * u[axis] * table[at(p, q)]
        if p:
            value -= root[p] * g[axis][axis] * table[at(p - 1, q)]
        if q:
            value -= root[q] * g[0][1] * table[at(p, q - 1)]
        table[n, m] = value / root[p + 1]
    return table


def symmetric_power(a: Matrix, order: int) -> list[list[Any]]:
    """Return Sym^N(a) to 60 digits of |a|^N.

    Column (N−j, j) holds the coefficients of (a11 X + a21 Y)^(N−j) (a12 X + a22 Y)^j, here in
    fixed-point integers.
    """
    # binomials and norms grow like 2^N each
    bits = 240 + 2 * order
    size = max(abs(value) for row in a for value in row)
    entry = [[int(mp.ldexp(value / size, bits)) for value in row] for row in a]

    def powers(p: int, q: int) -> list[list[int]]:
        rows = [[1 << bits]]
        for _ in range(order):
            last = rows[-1]
            both = zip([*last, 0], [0, *last], strict=True)
            rows.append([(p * c + q * d) >> bits for c, d in both])
        return rows

    first, second = powers(entry[0][0], entry[1][0]), powers(entry[0][1], entry[1][1])
    norm = [mp.sqrt(mp.factorial(order - i) * mp.factorial(i)) for i in range(order + 1)]
    columns = []
    for j in range(order + 1):
        left, right = first[order - j], np.array(second[j], dtype=object)
        column = np.zeros(order + 1, dtype=object)
        for i, c in enumerate(left):
            column[i : i + j + 1] += c * right
        scale = mp.ldexp(size**order / norm[j], -2 * bits)
        columns.append([n * mp.mpf(value) * scale for n, value in zip(norm, column, strict=True)])
    return transpose(columns)


def gaussian_table(start: Any, m: Matrix, orders: Sequence[int]) -> Table:  # noqa: ANN401
    """Return the coefficients o_p of start · exp(−u'mu) = Σ Π(√2 u_i)^(p_i)/√(p_i!) o_p."""
    root = [mp.sqrt(n) for n in range(max(orders) + 1)]
    size = len(orders)
    table = {(0,) * size: start}
    for p in product(*(range(n + 1) for n in orders)):
        if sum(p) == 0:
            continue
        if sum(p) % 2:
            table[p] = mp.mpf(0)
            continue
        i = next(axis for axis in range(size) if p[axis])
        low = [*p]
        low[i] -= 1
        value = mp.mpf(0)
        for j in range(size):
            if low[j]:
                low[j] -= 1
                value -= m[i][j] * root[low[j] + 1] * table[tuple(low)]
                low[j] += 1
        table[p] = value / root[p[i]]
    return table


def overlap_table(w1: Matrix, w2: Matrix, orders: Sequence[int]) -> Table:
    """Return ⟨φ_ab(·; W1)|φ_nm(·; W2)⟩ up to the orders of (a, b, n, m).

    ∫ exp(−|Zx|²/2 + 2u'Zx − u'u) d²x = 2π|K|^½ exp(−u'(1 − 2ZKZ')u), Z = [W1; W2], K = (Z'Z)⁻¹.
    """
    z = [*w1, *w2]
    gram = [[sum(row[i] * row[j] for row in z) for j in (0, 1)] for i in (0, 1)]
    k = inverse(gram)
    half = [apply(k, row) for row in z]
    m = [
        [int(i == j) - 2 * (z[i][0] * half[j][0] + z[i][1] * half[j][1]) for j in range(4)]
        for i in range(4)
    ]
    weight = mp.sqrt(abs(determinant(w1) * determinant(w2)))
    return gaussian_table(2 * mp.sqrt(determinant(k)) * weight, m, orders)


def pairs(order: int) -> list[tuple[int, int]]:
    """Return the pairs of orders with a + b ≤ order."""
    return [(n - b, b) for n in range(order + 1) for b in range(n + 1)]


def line_overlaps(ratio: Any, orders: Sequence[int]) -> Table:  # noqa: ANN401
    """Return ∫ h_a(x) √w h_n(wx) dx for w = `ratio` up to the two orders, as in the plane."""
    total = 1 + ratio * ratio
    m = [[1 - 2 / total, -2 * ratio / total], [-2 * ratio / total, 1 - 2 * ratio * ratio / total]]
    return gaussian_table(mp.sqrt(2 * ratio / total), m, orders)


def line_integrals(order: int, tau: Any) -> list[Any]:  # noqa: ANN401
    """Return ∫ h_n over (−τ, τ), n ≤ `order`, since h_n' = √(n/2) h_{n−1} − √((n+1)/2) h_{n+1}."""
    h = HermiteDigits(order + 1, tau)
    values = [mp.sqrt(2) * mp.root(mp.pi, 4) * mp.erf(tau / mp.sqrt(2)), mp.mpf(0)]
    for n in range(1, order):
        ends = 2 * h[n] if n % 2 else mp.mpf(0)
        values.append((mp.sqrt(mp.mpf(n) / 2) * values[n - 1] - ends) / mp.sqrt(mp.mpf(n + 1) / 2))
    return values[: order + 1]


def gaussian_projection(s: Matrix, p: Matrix, w: Matrix, order: int) -> Table:
    """Return ∫ I(x) h_a h_b(W^-T P'x) d²x 2π|det W|^-½ for I = exp(−x'S⁻¹x/2).

    The modes of F{I}(P·) but for (−i)^(a+b).  With y = Vx the generating function integrates to a
    Gaussian again: K = (S⁻¹ + V'V)⁻¹, exponent −u'(1 − 2VKV')u.
    """
    v = matmul(transpose(inverse(w)), transpose(p))
    gram, si = matmul(transpose(v), v), inverse(s)
    k = inverse([[si[i][j] + gram[i][j] for j in (0, 1)] for i in (0, 1)])
    middle = matmul(matmul(v, k), transpose(v))
    m = [[int(i == j) - 2 * middle[i][j] for j in (0, 1)] for i in (0, 1)]
    start = 4 * mp.pi**1.5 * mp.sqrt(determinant(k) / abs(determinant(w)))
    table = gaussian_table(start, m, (order, order))
    return {place: table[place] for place in pairs(order)}
