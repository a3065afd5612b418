"""Questions about h_n, φ_ab, Ψ_nm and its dual at every order, condition number and argument."""

from collections.abc import Iterator
from itertools import product
from typing import Any

import hermite_gauss as hg
import numpy as np
from light_grids import turn
from mpmath import mp
from scipy.special import roots_hermite
from stress import Expected, Question, root, rounding, shape, varied

BANDS = {"n 0-8": (0, 8), "n 9-64": (9, 64), "n 65-256": (65, 256)}


def band(order: int) -> str:
    """Return the name of the band that holds `order`."""
    return next(name for name, (low, high) in BANDS.items() if low <= order <= high)


def orders(rng: np.random.Generator, full: bool) -> list[int]:
    """Return orders of every band, the ends included."""
    if full:
        return [*range(80), *range(80, 257, 4), 127, 129, 255]
    fixed = [0, 1, 2, 3, 4, 5, 7, 8, 9, 16, 31, 32, 33, 63, 64, 65, 96, 127, 128, 129, 255, 256]
    return sorted({*fixed, *(int(n) for n in rng.integers(9, 256, 6))})


def envelope(n: int, h: hg.HermiteDigits) -> Any:  # noqa: ANN401
    """Return max(|h_n|, |h_{n−1}|), which has no zero."""
    return max(abs(h[n]), abs(h[n - 1])) if n else abs(h[0])


def ask_hermite(n: int, t: float, h: hg.HermiteDigits, where: str, kind: str) -> Question:
    """Return the question for h_n(t), whose table is `h`."""
    sensitivity = abs(mp.mpf(t) * hg.slope(n, mp.mpf(t), h))
    expected = Expected(h[n], envelope(n, h), sensitivity, rounding(n))
    region = f"h_n {kind}, {band(n)}, {where}"
    return Question(region, ("hermite1d", {"n": n, "t": t}), {("value",): expected}, kind)


def neighbours(t: float, steps: int = 1) -> list[float]:
    """Return `t` and the numbers next to it."""
    up, down = [t], [t]
    for _ in range(steps):
        up.append(float(np.nextafter(up[-1], np.inf)))
        down.append(float(np.nextafter(down[-1], -np.inf)))
    return [*reversed(down[1:]), *up]


def hermite_questions(full: bool) -> Iterator[Question]:
    """h_n in both number types."""
    for kind in ("f64", "f32"):
        yield from hermite_of_kind(full, kind)


def hermite_of_kind(full: bool, kind: str) -> Iterator[Question]:
    """h_n from 1e-300 to 1e308: between zeros, at zeros, at the turning points, in the tail."""
    rng = np.random.default_rng(11)
    dense = 8 if full else 1
    switch = {"f64": 37.0, "f32": 12.5}[kind]
    all_orders = orders(rng, full)
    tiny = [s * 10.0**-e for e in (300, 160, 100, 30, 16, 9, 6, 3) for s in (1, -1)]
    inside = rng.uniform(-23, 23, 60 * dense)
    tail = rng.uniform(23, 62, 90 * dense) * rng.choice([1, -1], 90 * dense)
    near = [s * t for t in neighbours(switch, 3) for s in (1, -1)]
    near += list(switch * (1 + rng.normal(scale=0.02, size=20 * dense)))
    places = {"|t| < 1e-3": [0.0, *tiny], "|t| < 23": inside, "23 < |t| < 62": tail}
    places[f"|t| about {switch}"] = near
    narrow = np.float32 if kind == "f32" else np.float64
    for where, arguments in places.items():
        for t in {float(narrow(t)) for t in arguments}:
            h = hg.HermiteDigits(256, mp.mpf(t))
            for n in all_orders:
                yield ask_hermite(n, t, h, where, kind)
    for n in all_orders:
        if n < 2:
            continue
        zeros = roots_hermite(n)[0][n // 2 :]
        turning = np.sqrt(2 * n + 1)
        some = zeros[np.unique(np.linspace(0, len(zeros) - 1, 4 * dense, dtype=int))]
        at_zeros = [v for t in some for v in neighbours(float(narrow(t)))]
        at_turning = list(turning * (1 + np.array([-0.1, -0.01, -1e-6, 0, 1e-6, 0.01, 0.1])))
        for where, arguments in (("at its zeros", at_zeros), ("at turning points", at_turning)):
            for t in {float(narrow(t)) for t in arguments}:
                yield ask_hermite(n, t, hg.HermiteDigits(n, mp.mpf(t)), where, kind)
    # beyond 1e3 every order is below 1e-200000
    zero = Expected(mp.mpf(0), mp.mpf(0), mp.mpf(0), 0.0)
    for t in (1e3, -1e4, 3.7e4, 5e5, -1e9, 1e30, 1e154, -1e155, 1e300, 1.7e308):
        for n in (0, 1, 64, 255, 256):
            if abs(t) < float(np.finfo(narrow).max):
                region = f"h_n {kind}, |t| from 1e3 up"
                case = ("hermite1d", {"n": n, "t": float(narrow(t))})
                yield Question(region, case, {("value",): zero}, kind)


def narrowed_questions(full: bool) -> Iterator[Question]:
    """h_n in f32 where `t` is no 32-bit number: its rounding may count, nothing else."""
    rng = np.random.default_rng(12)
    for t in rng.uniform(-14, 14, 400 if full else 60):
        h = hg.HermiteDigits(64, mp.mpf(float(t)))
        for n in (0, 1, 2, 5, 8, 13, 21, 34, 48, 64):
            question = ask_hermite(n, float(t), h, "t of 64 bits", "f32")
            question.expected["value",].scale += question.expected["value",].sensitivity
            yield question


def phi_questions(full: bool) -> Iterator[Question]:
    """φ_ab for roots of cond Θ from 1 to 1e24 and sizes from 1e-9 to 1e9.

    Allowed is the rounding of y = Wx and of det W to a few units in their *own* last places, which
    is much less than what rounded inputs do where Wx cancels.
    """
    rng = np.random.default_rng(13)
    conditions = [1.0, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12, 1e18, 9e23]
    kinds = ["|y| < 1", "oscillating", "turning point", "tail", "|y| 1e-9"]
    for (low, high), condition in [
        (limits, c)
        for limits in BANDS.values()
        for c in conditions
        for _ in range(12 if full else 3)
    ]:
        for where in kinds:
            size = 10.0 ** rng.uniform(-9, 9)
            w = root(rng, condition, size)
            n = int(rng.integers(low, high + 1))
            b = int(rng.integers(0, n + 1))
            a = n - b
            reach = np.sqrt([2 * a + 1, 2 * b + 1])
            y = {
                "|y| < 1": rng.uniform(-1, 1, 2),
                "oscillating": rng.uniform(-0.8, 0.8, 2) * reach,
                "turning point": reach * (1 + rng.normal(scale=0.02, size=2)),
                "tail": rng.permutation([rng.uniform(24, 30), rng.uniform(5, 20)]),
                "|y| 1e-9": rng.normal(scale=1e-9, size=2),
            }[where]
            x = np.array(hg.apply(hg.inverse(hg.exact(w)), hg.exact(y)), float)
            yield ask_phi(a, b, w, x, f"φ_ab, cond Θ {condition:.0e}")
    # far beyond the last number that is not 0, where Wx itself may be beyond 1e308
    for size, x in product((1.0, 1e60), ((1e4, 0.0), (1e150, -1e150), (-1e300, 1e300))):
        for w, (a, b) in product((size * np.eye(2), size * turn(np.pi / 4)), ((0, 0), (255, 1))):
            case = ("phi", {"a": a, "b": b, "W": w, "x": list(x)})
            zero = Expected(mp.mpf(0), mp.mpf(0), mp.mpf(0), 0.0)
            yield Question("φ_ab, |y| from 1e4 up", case, {("value",): zero})


def narrow_phi_questions(full: bool) -> Iterator[Question]:
    """φ_ab in f32, whose coordinates y are rounded to f32 at the end."""
    rng = np.random.default_rng(15)
    for condition in [1.0, 1e4, 1e12] * (20 if full else 4):
        w = root(rng, condition, 1.0)
        a, b = (int(n) for n in rng.integers(0, 33, 2))
        y = rng.uniform(-1.1, 1.1, 2) * np.sqrt([2 * a + 1, 2 * b + 1])
        x = np.array(hg.apply(hg.inverse(hg.exact(w)), hg.exact(y)), float)
        question = ask_phi(a, b, w, x, "φ_ab f32, orders up to 64")
        question.kind = "f32"
        yield question


def ask_phi(a: int, b: int, w: np.ndarray, x: np.ndarray, region: str) -> Question:
    """Return the question for φ_ab(x; W)."""
    we, xe = hg.exact(w), hg.exact(x)
    y = hg.apply(we, xe)
    first, second = hg.HermiteDigits(a, y[0]), hg.HermiteDigits(b, y[1])
    size = mp.sqrt(abs(hg.determinant(we)))
    value = size * first[a] * second[b]
    slopes = [size * hg.slope(a, y[0], first) * second[b]]
    slopes.append(size * first[a] * hg.slope(b, y[1], second))
    # what ulps of W and x do
    sensitivity = (
        sum(abs(we[i][j] * xe[j] * slopes[i]) * 2 for i in (0, 1) for j in (0, 1))
        + abs(value) * (abs(we[0][0] * we[1][1]) + abs(we[0][1] * we[1][0])) / size**2
    )
    # what an ulp of y itself does, and the envelope
    moved = sum(abs(y[i] * slopes[i]) for i in (0, 1))
    scale = size * envelope(a, first) * envelope(b, second) + moved
    expected = Expected(value, scale, sensitivity, rounding(a + b))
    case = ("phi", {"a": a, "b": b, "W": w, "x": x})
    return Question(region, case, {("value",): expected})


def psi_questions(full: bool) -> Iterator[Question]:
    """Ψ_nm, its dual, Ψ(0) and the Fourier pair from Θ itself, out to 8 standard deviations.

    Promised are 5 ε of the value itself for orders up to 40 on each axis, 8 (n + m) ε for Ψ(0): far
    less than what an ulp of a thin Θ does.
    """
    rng = np.random.default_rng(14)
    low = [p for p in hg.pairs(8) if sum(p) in (0, 1, 2, 3, 5, 8)]
    high = [(40, 40), (40, 0), (3, 37), (21, 20)]
    for condition in [1.0, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12, 1e14]:
        for dual in (0, 1):
            for reach in (1e-6, 1.0, 3.0, 8.0) * (3 if full else 1):
                theta = shape(rng, condition, 10.0 ** rng.uniform(-6, 6))
                y = rng.normal(size=2)
                y *= reach / np.linalg.norm(y)
                x = np.linalg.cholesky(theta) @ y
                with mp.workdps(160):
                    yield from ask_psi(low, theta, x, dual, f"cond Θ {condition:.0e}")
                if full or (reach == 3.0 and condition in (1e2, 1e8, 1e14)):
                    # terms of these orders cancel like cond^40
                    with mp.workdps(700):
                        yield from ask_high_psi(high, theta, x, dual)


def entries(theta: np.ndarray) -> list:
    """Return the three numbers of a symmetric matrix."""
    return hg.exact([theta[0, 0], theta[0, 1], theta[1, 1]])


def ask_psi(
    chosen: list[tuple[int, int]], theta: np.ndarray, x: np.ndarray, dual: int, name: str
) -> Iterator[Question]:
    """Yield the questions for some Ψ_nm(x), their transforms and, once per Θ, their centres."""
    order = max(map(sum, chosen))
    inverse = hg.inverse(hg.exact(theta))
    # a frequency of the same whitened size
    zeta = np.array(hg.apply(inverse, hg.exact(x)), float)

    def table(v: list) -> hg.Table:
        return hg.covariant_table(order, [[v[0], v[1]], [v[1], v[2]]], v[3:], dual=bool(dual))

    def transform(v: list) -> hg.Table:
        g = hg.inverse([[v[0], v[1]], [v[1], v[2]]])
        return hg.covariant_table(order, g, v[3:], dual=not dual)

    kinds = [
        ("Ψ and Ψ̃", table, "psi", {"x": x, "dual": dual}, x),
        ("F{Ψ}", transform, "ft_psi", {"zeta": zeta, "dual": dual}, zeta),
        ("Ψ(0)", table, "psi_zero", {}, np.zeros(2)),
    ]
    for title, function, op, more, place in kinds[: 2 if dual else 3]:
        values, changes = varied(function, [*entries(theta), *hg.exact(place)])
        for n, m in chosen:
            value = values[n, m]
            if op == "ft_psi":
                value *= 2 * mp.pi * mp.mpc(0, -1) ** (n + m)
            allowed = 8.0 * (n + m + 1) if op == "psi_zero" else 5.0
            expected = Expected(value, abs(value), changes[n, m], allowed)
            case = (op, {"n": n, "m": m, "Theta": theta, **more})
            yield Question(f"{title}, {name}", case, {("value",): expected})


def ask_high_psi(
    chosen: list[tuple[int, int]], theta: np.ndarray, x: np.ndarray, dual: int
) -> Iterator[Question]:
    """Yield the questions for some Ψ_nm(x) of high order, where it is a 64-bit number."""
    t = hg.exact(theta)
    for n, m in chosen:
        table = hg.covariant_table(n + m, t, hg.exact(x), dual=bool(dual), most=(n, m))
        value = table[n, m]
        if not 1e-300 < abs(value) < 1e300:
            continue
        case = ("psi", {"n": n, "m": m, "Theta": theta, "x": x, "dual": dual})
        expected = Expected(value, abs(value), mp.mpf(0), 5.0)
        yield Question("Ψ and Ψ̃, orders up to 40 + 40", case, {("value",): expected})
