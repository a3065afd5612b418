"""Questions about overlaps, symmetric powers and projections, and about light in space."""

from collections.abc import Iterator
from typing import Any

import hermite_gauss as hg
import numpy as np
from light_grids import turn
from mpmath import mp
from stress import Expected, Question, from_inputs, root, rounding, shape, varied


def overlap_questions(full: bool) -> Iterator[Question]:
    """⟨φ_ab(·; W1)|φ_nm(·; W2)⟩ for thin and for very different shapes, up to order 3 or 5.

    Modes of one total order mix with those of that order: the scale is the norm of their block.
    """
    rng = np.random.default_rng(21)
    order = 5 if full else 3
    conditions = [(1.0, 1.0), (1e2, 1.0), (1e4, 1e4), (1e8, 1.0), (1e8, 1e8), (1e12, 1e12)]
    ratios = [1.0, 1e3, 1e-9, 1e9]
    for (first, second), ratio in [(c, r) for c in conditions for r in ratios]:
        for _ in range(4 if full else 1):
            size = 10.0 ** rng.uniform(-6, 6)
            w1, w2 = root(rng, first, size), root(rng, second, size * ratio)
            with mp.workdps(90):
                yield from ask_overlaps(
                    w1, w2, order, f"overlap, cond Θ {first:.0e} | {second:.0e}"
                )
    # the same thin shape but for a few ulps, or turned a little
    for condition in (1e4, 1e8, 1e12):
        w1 = root(rng, condition, 1.0)
        for w2 in (w1, w1 * (1 + 1e-15), w1 @ turn(1e-9), turn(0.3) @ w1):
            with mp.workdps(90):
                yield from ask_overlaps(w1, w2, order, f"overlap, nearly the same, {condition:.0e}")


def ask_overlaps(w1: np.ndarray, w2: np.ndarray, order: int, region: str) -> Iterator[Question]:
    """Yield a question for every second pair of modes up to `order`."""

    def table(v: list[Any]) -> hg.Table:
        return hg.overlap_table([v[:2], v[2:4]], [v[4:6], v[6:8]], [order] * 4)

    values, changes = varied(table, hg.exact([*w1.ravel(), *w2.ravel()]))
    block: dict[tuple[int, int], Any] = {}
    for (a, b, n, m), value in values.items():
        block[a + b, n + m] = block.get((a + b, n + m), 0) + value**2
    chosen = [p for p in values if p[0] + p[1] <= order and p[2] + p[3] <= order]
    for a, b, n, m in chosen[::2]:
        value, change = values[a, b, n, m], changes[a, b, n, m]
        scale = mp.sqrt(block[a + b, n + m]) + change
        expected = Expected(value, scale, change, rounding(a + b + n + m))
        case = ("overlap", {"a": a, "b": b, "n": n, "m": m, "W1": w1, "W2": w2})
        yield Question(region, case, {("value",): expected})


def high_overlap_questions(full: bool) -> Iterator[Question]:
    """Overlaps of high orders on common axes, where they are products.

    A common turn of the axes is found to an ulp only, so that modes of one order mix: the scale is
    the norm of those.
    """
    ratios = [1.0, 1.0 + 1e-9, 1.5, 4.0, 1e-2, 30.0, 1e3, 1e-9]
    for order, some in ((64, ratios), (160, ratios[2:6] if full else [1.5, 4.0])):
        lines = {ratio: hg.line_overlaps(mp.mpf(ratio), (order, order)) for ratio in some}
        for r1, r2 in zip(some, some[3:] + some[:3], strict=True):
            for share in ((1, 0, 1, 0), (1, 0, 0.5, 0), (0.5, 0.5, 0.5, 0.5), (0.9, 0.1, 0.1, 0.9)):
                a, b, n, m = (round(order * part) for part in share)
                value = lines[r1][a, n] * lines[r2][b, m]
                rows, columns = range(a + b + 1), range(n + m + 1)
                near = [
                    lines[r1][i, j] * lines[r2][a + b - i, n + m - j] for i in rows for j in columns
                ]
                scale = mp.sqrt(sum(v * v for v in near))
                expected = Expected(value, scale, abs(value), rounding(a + b + n + m))
                axes = {"W1": np.eye(2), "W2": np.diag([r1, r2])}
                case = ("overlap", {"a": a, "b": b, "n": n, "m": m, **axes})
                yield Question(f"overlap, order {order}", case, {("value",): expected})


def power_questions(full: bool) -> Iterator[Question]:
    """Sym^N(A): rotations, shears and thin matrices; the error is counted over |A|^N."""
    rng = np.random.default_rng(22)
    matrices = {
        "rotation": [turn(angle) for angle in (1e-8, 0.3, 0.7853981633974483, 1.6, -2.9)],
        "general": list(rng.normal(size=(3, 2, 2))),
        "thin": [np.diag([1.0, 1e-9]), root(rng, 1e16, 1e-3), np.array([[1.0, 1e4], [0.0, 1.0]])],
    }
    orders = [1, 2, 5, 16, 64, 128, 256] if full else [1, 2, 5, 16, 64]
    for name, entries in matrices.items():
        for a in entries:
            for n in orders + [128] * (name == "rotation" and not full and a is entries[1]):
                scale = mp.mpf(float(np.linalg.norm(a, 2))) ** n
                if scale > 1e300:
                    continue
                truth = hg.symmetric_power(hg.exact(a), n)
                # N steps, each of |A|, of which the roundings add up
                question = Question(f"Sym^N, {name}", ("sym_power", {"A": a, "N": n}))
                # a few hundred entries, all rows and columns among them
                for place in range(0, (n + 1) ** 2, max(1, (n + 1) ** 2 // 400)):
                    i, j = divmod(place, n + 1)
                    expected = Expected(truth[i][j], scale, abs(truth[i][j]), rounding(n))
                    question.expected["matrix", i, j] = expected
                yield question


def projection_questions(full: bool) -> Iterator[Question]:
    """Rectangles on their axes and Gaussians over any other shape, orders up to 64 (full: 128)."""
    order = 128 if full else 64
    unit = mp.sqrt(mp.mpf(3))
    for hx, hy, wx, wy in [
        (1.3, 0.4, None, None),
        (2e-6, 5e-2, None, None),
        (1.0, 1.0, 0.125, 2.0),
        (1e-4, 3.0, 1e-5, 0.5),
        (1.0, 1.0, 1e-3, 1e3),
    ]:
        inputs: dict[str, Any] = {"I": {"kind": "rect", "hx": hx, "hy": hy}, "P": np.eye(2)}
        half = hg.exact([hx, hy])
        if wx is not None and wy is not None:
            inputs["W"] = np.diag([wx, wy])
            w = hg.exact([wx, wy])
        else:
            w = [half[0] / unit, half[1] / unit]
        lines = [hg.line_integrals(order, half[i] / w[i]) for i in (0, 1)]
        weight = 2 * mp.pi * mp.sqrt(w[0] * w[1])
        values = {(a, b): weight * lines[0][a] * lines[1][b] for a, b in hg.pairs(order)}
        yield ask_projection(inputs, values, {}, order, "projection, rectangle")
    rng = np.random.default_rng(23)
    for condition in (1.0, 1e4, 1e8):
        s = shape(rng, condition, 10.0 ** rng.uniform(-8, 2))
        for stretch in (0.5, 3.0):
            w = stretch * np.linalg.cholesky(s).T @ turn(0.4)
            inputs = {"I": {"kind": "gaussian", "S": s}, "P": turn(0.4), "W": w}
            given = hg.exact([s[0, 0], s[0, 1], s[1, 1], *inputs["P"].ravel(), *w.ravel()])

            def modes(v: list[Any]) -> hg.Table:
                p, root = [v[3:5], v[5:7]], [v[7:9], v[9:11]]
                return hg.gaussian_projection([[v[0], v[1]], [v[1], v[2]]], p, root, 24)

            with mp.workdps(100):
                values, changes = varied(modes, given)
            region = f"projection, Gaussian, cond S {condition:.0e}"
            yield ask_projection(inputs, values, changes, 24, region)


def ask_projection(
    inputs: dict[str, Any], values: hg.Table, changes: hg.Table, order: int, region: str
) -> Question:
    """Return the question for all modes of one envelope.

    The scale is the norm of the series and of what an ulp of each input does to it, if known.
    """
    scale = mp.sqrt(sum(v * v for v in [*values.values(), *changes.values()]))
    question = Question(region, ("projection", {**inputs, "N": order}))
    for (a, b), value in values.items():
        quarter = mp.mpc(0, -1) ** (a + b)
        change = changes.get((a, b), mp.mpf(0))
        expected = Expected(quarter * value, scale, change, rounding(a + b))
        question.expected["white", a + b, b] = expected
    return question


def light_questions(full: bool) -> Iterator[Question]:
    """C(ξ) and W(ζ) from 300 nm to 10 cm, 1 m to 1e9 m, thin shapes, in the tails as well."""
    rng = np.random.default_rng(24)
    order = 5
    for wavelength in (3e-7, 5.5e-7, 1e-5, 1e-3, 0.1):
        # the far field begins at 100/k
        for distance in (max(1.0, 20 * wavelength), 2e3, 1e9):
            for condition in (1.0, 1e4, 1e8):
                for reach in (0.3, 3.0, 20.0) if full else (float(rng.choice([0.3, 3.0, 20.0])),):
                    yield from ask_light(rng, wavelength, distance, condition, reach, order)


def ask_light(
    rng: np.random.Generator,
    wavelength: float,
    distance: float,
    condition: float,
    reach: float,
    order: int,
) -> Iterator[Question]:
    """Yield one question each for the CSD and the Wigner function of one Hermitian series."""
    # the source is 1 µm to 10 m wide
    theta = shape(rng, condition, 10.0 ** rng.uniform(-2, 12))
    q = turn(rng.uniform(-np.pi, np.pi))
    factor = np.linalg.cholesky(theta)
    y = rng.normal(size=2)
    y *= reach / np.linalg.norm(y)
    to_xi = distance * wavelength / (2 * np.pi) * q.T @ factor
    chosen = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 2), (0, 5)]
    width = np.sqrt(np.diag(theta))
    modes = []
    for n, m in chosen:
        size = rng.normal() * width[0] ** n * width[1] ** m
        modes.append([n, m, complex(size) if (n + m) % 2 == 0 else 1j * size])
    inputs = {"lambda": wavelength, "r": distance, "Theta": theta, "Q": q, "modes": modes}
    amounts = [c.real if c.imag == 0 else c.imag for *_, c in modes]

    def values(v: list[Any], op: str) -> hg.Table:
        (lam, r), t, qe, place = v[:2], [v[2:4], [v[3], v[4]]], [v[5:7], v[7:9]], v[9:11]
        k = 2 * mp.pi / lam
        w = hg.apply(qe, place)
        if op == "csd":
            table = hg.covariant_table(order, t, [k / r * p for p in w], dual=False)
            factors = [mp.mpc(0, 1) ** ((n + m) % 2) / r**2 for n, m in chosen]
        else:
            table = hg.covariant_table(order, hg.inverse(t), [r / k * p for p in w], dual=True)
            factors = [
                2 * mp.pi / k**2 * mp.mpc(0, -1) ** (n + m) * mp.mpc(0, 1) ** ((n + m) % 2)
                for n, m in chosen
            ]
        terms = [f * c * table[p] for f, c, p in zip(factors, v[11:], chosen, strict=True)]
        # even and odd orders are the real and the imaginary part
        return {(0,): sum(terms), (1,): sum(abs(term) for term in terms)}

    with mp.workdps(120):
        start = [wavelength, distance, theta[0, 0], theta[0, 1], theta[1, 1], *q.ravel()]
        for op, name, key, place in (
            ("csd", "xi", "C", to_xi @ y),
            ("wvd", "zeta", "W", np.linalg.solve(to_xi.T, y)),
        ):
            vector = hg.exact([*start, *place, *amounts])
            here, change = varied(lambda v, op=op: values(v, op), vector)
            value = here[0,]
            expected = from_inputs(value, change[0,], order)
            expected.scale += here[1,]
            region = f"{'C(ξ)' if op == 'csd' else 'W(ζ)'}, cond Θ {condition:.0e}"
            yield Question(region, (op, {**inputs, name: place}), {(key,): expected})
