"""Theorem S4.1 against sums over pairs of points of the matter."""

from functools import cache
from typing import Any

import numpy as np
from common import Array
from evaluate import Case, Program
from hermite_gauss import hermite_table
from light_grids import EPS, STEP, Rows, largest
from scattering_matter import (
    Spec,
    encounter,
    footprint,
    hermitian_modes,
    map_of,
    series,
    value,
)

ENVELOPES = ("gaussian", "gaussian_mixture")
PAIRS = 1e-10
# half-width and points per axis of a rule over x₁ and of that over x₂
RULES = ((9.0, 40), (9.4, 45))
CASES = 3


def lattice(half: float, points: int) -> tuple[Array, float]:
    """Return points of a line, not symmetric about 0, and their distance."""
    step = 2 * half / (points - 1)
    return np.arange(points) * step - half + 0.3 * step, step


def mutual(inputs: Spec, x: Array) -> list[list[Array | None]]:
    """Return R^(j→l)(x) γ_j(x) at separations x, γ without 1/s²."""
    b, _, _ = map_of(inputs)
    light = inputs["incident"]
    gammas = [series(light["W"], named, x @ b.T) for named in light["modes"]]
    return [
        [None if r is None else value(r, x) * gamma for r, gamma in zip(row, gammas, strict=True)]
        for row in inputs["R"]
    ]


def transforms(
    inputs: Spec, unit: float, half: float, points: int
) -> tuple[Array, Array, Array, Array]:
    """Return A [4,4] and C [ξ,4] by sums over a grid, and the sums of moduli of both."""
    _, phi, p = map_of(inputs)
    k = 2 * np.pi / inputs["lambda"]
    t, step = lattice(half, points)
    t, step = unit * t, unit * step
    x = np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2)
    # every difference of two points and every sum of two lies on a grid of twice as many
    i = np.arange(points)
    less, more = (i[:, None] - i + points - 1), (i[:, None] + i)
    wide = 2 * points - 1
    difference = (np.arange(wide) - points + 1) * step
    mean = t[0] + 0.5 * step * np.arange(wide)
    apart = np.stack(np.meshgrid(difference, difference, indexing="ij"), -1)
    middle = np.stack(np.meshgrid(mean, mean, indexing="ij"), -1)
    products = mutual(inputs, apart)
    kernel = np.exp(-1j * apart @ phi)
    pre = (inputs["s"] * inputs["lambda"]) ** -2
    amplitudes, scale_a = np.zeros((4, 4), complex), 0.0
    rows = []
    for out, row in enumerate(products):
        present = [(j, f) for j, f in enumerate(row) if f is not None]
        for j, f in present:
            amplitudes[out, j] = pre * step**2 * (f * kernel).sum()
            scale_a = max(scale_a, pre * step**2 * np.abs(f).sum())
        rows.append(np.sum([f for _, f in present], 0) if present else np.zeros((wide, wide)))
    # pairs (x₁, x₂) as a matrix: index [i₁, k₁; i₂, k₂] of both axes
    at = (less[:, None, :, None], less[None, :, None, :])
    where = (more[:, None, :, None], more[None, :, None, :])
    size = points * points
    profile = footprint(inputs["I"], middle)[where].reshape(size, size)
    correlations, scale_c = np.zeros((len(inputs["xi"]), 4), complex), 0.0
    for out, row in enumerate(rows):
        pairs = profile * np.asarray(row, complex)[at].reshape(size, size)
        weight = pre / inputs["r"] ** 2 * step**4
        scale_c = max(scale_c, weight * np.abs(pairs).sum())
        for n, xi in enumerate(inputs["xi"]):
            kappa = k / inputs["r"] * p @ xi
            first, second = np.exp(-1j * x @ (phi + kappa / 2)), np.exp(1j * x @ (phi - kappa / 2))
            correlations[n, out] = weight * (first @ pairs @ second)
    return amplitudes, correlations, np.array(scale_a), np.array(scale_c)


@cache
def encounters(seed: int) -> list[tuple[Case, list[Any]]]:
    """Return cases of `interaction` with Gaussian envelopes and what two grids make of them."""
    rng = np.random.default_rng([seed, 3])
    made = []
    for envelope in ENVELOPES:
        for _ in range(CASES):
            inputs, unit = encounter(rng, envelope)
            sums = [transforms(inputs, unit, *rule) for rule in RULES]
            made.append((("interaction", inputs), sums))
    return made


def answers(program: Program, seed: int) -> list[dict[str, Any]]:
    """Return the program's results of these cases."""
    return program([case for case, _ in encounters(seed)])


def geometry(program: Program, seed: int) -> Rows:
    """B, φ and P of random directions."""
    worst = dict.fromkeys(("B", "phi_t", "P_out"), 0.0)
    for (case, _), found in zip(encounters(seed), answers(program, seed), strict=True):
        k = 2 * np.pi / case[1]["lambda"]
        expected = map_of(case[1])
        scales = (k / case[1]["s"], k, 1.0)
        for key, value_of, scale in zip(worst, expected, scales, strict=True):
            worst[key] = largest(worst[key], abs(np.array(found[key]) - value_of).max() / scale)
    for key, error in worst.items():
        yield f"{key}", error, 2 * STEP * EPS


def amplitudes(program: Program, seed: int) -> Rows:
    """A^(j→l), sixteen kinds of matter in one."""
    results = answers(program, seed)
    error = own = 0.0
    for (_, sums), found in zip(encounters(seed), results, strict=True):
        (a, _, scale, _), (again, *_) = sums
        error = largest(error, abs(np.array(found["A"]) - a).max() / scale)
        own = largest(own, abs(a - again).max() / scale)
        error = largest(error, abs(np.array(found["S"]) - a.sum(1)).max() / scale / 4)
    yield "A^(j→l) and their sums, over differences", error, PAIRS
    yield "  the quadrature by itself", own, PAIRS / 2


def double_integrals(program: Program, seed: int) -> Rows:
    """C_l(ξ) as A{G}(p₁, p₂)."""
    results = answers(program, seed)
    worst: dict[str, list[float]] = {kind: [0.0, 0.0] for kind in ENVELOPES}
    for (case, sums), found in zip(encounters(seed), results, strict=True):
        (_, c, _, scale), (_, again, _, _) = sums
        row = worst[case[1]["I"]["kind"]]
        row[0] = largest(row[0], abs(np.array(found["C_samples"]) - c).max() / scale)
        row[1] = largest(row[1], abs(c - again).max() / scale)
        light = c[0].real
        degree = np.sqrt((light[1:] ** 2).sum())
        row[0] = largest(row[0], abs(found["intensity"] - light[0]) / scale)
        # DoP · S0 is the length of the other three
        row[0] = largest(row[0], abs(found["DoP"] * found["intensity"] - degree) / scale)
    for kind, (error, own) in worst.items():
        yield f"C_l(ξ) = A{{G}}(p₁, p₂), ∫∫ d²x₁ d²x₂, {kind}", error, PAIRS
        yield "  the quadrature by itself", own, PAIRS / 2


def edge_case(rng: np.random.Generator) -> tuple[Spec, float]:
    """Return an encounter in which everything is a product of a function of x and one of y."""
    inputs, unit = encounter(rng, "rect")
    k = 2 * np.pi / inputs["lambda"]
    theta = rng.uniform(0.0, 1.2)
    incident, leaving = np.sin(theta), rng.normal() * 0.7 / (k * unit) - np.sin(theta)

    def frame(sine: float) -> tuple[Array, Array]:
        cosine = np.sqrt(1 - sine * sine)
        return np.array([sine, 0, cosine]), np.array([[cosine, 0, -sine], [0, 1.0, 0]])

    to_source, e_in = frame(incident)
    to_observer, e_out = frame(leaving)
    b = k / inputs["s"] * np.diag([np.sqrt(1 - incident**2), 1.0])
    light = np.diag(rng.uniform(0.45, 0.8, 2)) / unit @ np.linalg.inv(b)

    def along_axes() -> Spec:
        spec: Spec = {"amp": float(rng.normal()), "S": unit**2 * np.diag(rng.uniform(1.5, 4, 2))}
        if rng.random() < 0.5:
            return {"kind": "gaussian", **spec}
        grooves = {"G": np.array([0.5 / unit, 0.0]), "orders": rng.normal(size=3)}
        return {"kind": "grating", **spec, **grooves}

    return {
        **inputs,
        "to_source": to_source,
        "to_observer": to_observer,
        "t": np.eye(3)[:2],
        "e_in": e_in,
        "e_out": e_out,
        "incident": {"W": light, "modes": [hermitian_modes(rng, 3) for _ in range(4)]},
        "R": [[along_axes() for _ in range(4)] for _ in range(4)],
    }, unit


def box_sums(inputs: Spec, unit: float, step: float, nodes: int) -> tuple[Array, float]:
    """Return C_l(ξ) of separable matter on a rectangle, from pairs of points of each axis."""
    b, phi, p = map_of(inputs)
    k = 2 * np.pi / inputs["lambda"]
    light = inputs["incident"]
    order = 3
    node, weight = np.polynomial.legendre.leggauss(nodes)
    pre = (inputs["s"] * inputs["lambda"] * inputs["r"]) ** -2 * np.sqrt(np.linalg.det(light["W"]))
    total, scale = np.zeros((len(inputs["xi"]), 4), complex), 0.0
    for n, xi in enumerate(inputs["xi"]):
        kappa = k / inputs["r"] * p @ xi

        def along(axis: int, r: Spec, kappa: Array = kappa) -> tuple[Array, Array]:
            """∫∫ over one axis with every h_a, and of moduli; the edges are x₁ + x₂ = ±2h."""
            h = inputs["I"]["hx" if axis == 0 else "hy"]
            v = (light["W"] @ b)[axis, axis]
            x1 = np.arange(-h - 9 * unit, h + 9 * unit, step * unit)[:, None]
            x2 = 2 * h * node - x1
            d = x1 - x2
            f = np.exp(-0.5 * d**2 / r["S"][axis, axis])
            if axis == 0 and r["kind"] == "grating":
                f = f * sum(a * np.cos(q * r["G"][0] * d) for q, a in enumerate(r["orders"]))
            p1, p2 = (phi + kappa / 2)[axis], (phi - kappa / 2)[axis]
            f = f * weight * 2 * h * step * unit
            table = hermite_table(order, v * d)
            g = f * np.exp(-1j * (p1 * x1 - p2 * x2))
            return (table * g).sum((1, 2)), (np.abs(table) * np.abs(f)).sum((1, 2))

        for out, row in enumerate(inputs["R"]):
            for r, named in zip(row, light["modes"], strict=True):
                (jx, mx), (jy, my) = along(0, r), along(1, r)
                total[n, out] += pre * r["amp"] * sum(c * jx[a] * jy[m] for a, m, c in named)
                moduli = sum(abs(c) * mx[a] * my[m] for a, m, c in named)
                scale = max(scale, pre * abs(r["amp"]) * moduli)
    return total, scale


@cache
def edges(seed: int) -> list[tuple[Case, list[Any]]]:
    """Return cases of `interaction` on rectangles and what two rules make of them."""
    rng = np.random.default_rng([seed, 4])
    made = []
    for _ in range(CASES):
        inputs, unit = edge_case(rng)
        sums = [box_sums(inputs, unit, *rule) for rule in ((0.21, 60), (0.17, 70))]
        made.append((("interaction", inputs), sums))
    return made


def hard_edges(program: Program, seed: int) -> Rows:
    """C_l(ξ) as A{G}(p₁, p₂) on a rectangle: a product of double integrals over lines."""
    results = program([case for case, _ in edges(seed)])
    error = own = 0.0
    for (_, ((c, scale), (again, _))), found in zip(edges(seed), results, strict=True):
        error = largest(error, abs(np.array(found["C_samples"]) - c).max() / scale)
        own = largest(own, abs(c - again).max() / scale)
    yield "C_l(ξ) = A{G}(p₁, p₂), ∫∫ dx₁ dx₂ ∫∫ dy₁ dy₂, rect", error, PAIRS
    yield "  the quadrature by itself", own, PAIRS / 2
