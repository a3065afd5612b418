"""Lobes F{R Ψ(B·)}(φ) of one incident mode and of none, against trapezoid sums over the plane."""

from functools import cache

import numpy as np
from common import Array
from evaluate import Case, Program
from hermite_gauss import hermite_table
from light_grids import EPS, STEP, Rows, grid, largest, turn
from scattering_matter import (
    KINDS,
    Spec,
    autocorrelation,
    covariance,
    root,
    value,
    without_decay,
)
from scipy.special import factorial

# half-width and step in which exp(−|x|²/2) and its transform, and those of the cases, are below ε
EXTENT, STEPS = 26.0, (0.31, 0.27)
ORDER = 5


@cache
def lobe_cases(seed: int) -> list[tuple[Case, complex, float, float]]:
    """Return cases of `lobe` with value, sum of moduli, and what a second grid gives."""
    rng = np.random.default_rng([seed, 1])
    made = []
    for kind in KINDS:
        for unit in (1.0, 3e-6, 40.0):
            r, phi = autocorrelation(rng, kind, unit), rng.normal(size=2) / unit
            sums = []
            for step in STEPS:
                x, weight = grid(EXTENT, step)
                f = unit**2 * weight * (value(r, unit * x) - without_decay(r))
                sums.append((f @ np.exp(-1j * unit * x @ phi), np.abs(f).sum() + 1e-300))
            (first, scale), (second, _) = sums
            made.append((("lobe", {"R": r, "phi": phi}), first, scale, abs(first - second)))
    return made


def lobes(program: Program, seed: int) -> Rows:
    """F{R − R(∞)}(φ) and R(∞)."""
    cases = lobe_cases(seed)
    results = program([case for case, *_ in cases])
    # φ·x of up to 60 rad, rounded, and the rounding of R
    bound = 100 * STEP * EPS
    for kind in KINDS:
        mine = [i for i, (case, *_) in enumerate(cases) if case[1]["R"]["kind"] == kind]
        values = [abs(results[i]["value"] - cases[i][1]) / cases[i][2] for i in mine]
        yield f"F{{R}}(φ), {kind}", largest(values), bound
        yield (
            "  the quadrature by itself",
            largest(cases[i][3] / cases[i][2] for i in mine),
            bound / 2,
        )
        far = [without_decay(cases[i][0][1]["R"]) for i in mine]
        error = [abs(results[i]["coherent_weight"] - w) for i, w in zip(mine, far, strict=True)]
        yield f"R(∞), {kind}", largest(error), STEP * EPS * (1 + largest(map(abs, far)))


def white_sums(
    r: Spec, w: Array, b: Array, phi: Array, unit: float, step: float
) -> tuple[Array, Array]:
    """Return F{R φ_ab(B·; W)}(φ) for all a, b ≤ ORDER, and the sums of moduli."""
    x, weight = grid(EXTENT, step)
    y = unit * x @ (w @ b).T
    h0, h1 = hermite_table(ORDER, y[:, 0]), hermite_table(ORDER, y[:, 1])
    f = unit**2 * weight * np.sqrt(abs(np.linalg.det(w))) * value(r, unit * x)
    g = f * np.exp(-1j * unit * x @ phi)
    moduli = np.abs(h0) * np.abs(f) @ np.abs(h1).T
    return (h0 * g) @ h1.T, moduli


def covariant_sums(
    r: Spec, theta: Array, b: Array, phi: Array, unit: float, step: float
) -> tuple[Array, Array]:
    """Return F{R Ψ^Θ_nm(B·)}(φ) for all n, m ≤ ORDER from the integral of the generating function.

    Cauchy's integral over two circles of the parameters takes it apart.
    """
    x, weight = grid(EXTENT, step)
    inverse = np.linalg.inv(theta)
    u = unit * x @ b.T
    start = np.exp(-0.5 * np.einsum("pi,ij,pj->p", u, inverse, u))
    start /= np.sqrt(np.pi) * np.linalg.det(theta) ** 0.25
    f = unit**2 * weight * value(r, unit * x) * start * np.exp(-1j * unit * x @ phi)
    points = 32
    circle = 0.8 * np.exp(2j * np.pi * np.arange(points) / points)
    scale = 1 / np.sqrt(np.diag(inverse))
    v = 2 * u @ inverse
    e0, e1 = (np.exp(np.outer(scale[i] * circle, v[:, i])) for i in range(2))
    a = np.stack(np.meshgrid(scale[0] * circle, scale[1] * circle, indexing="ij"))
    squares = np.exp(-np.einsum("i...,ij,j...->...", a, inverse, a))
    table = np.fft.fft2(((e0 * f) @ e1.T) * squares)[: ORDER + 1, : ORDER + 1] / points**2
    n = np.arange(ORDER + 1)
    weights = [np.sqrt(factorial(n) / 2.0**n) / (0.8 * s) ** n for s in scale]
    moduli = (np.abs(e0) * np.abs(f)) @ np.abs(e1).T * np.abs(squares)
    outer = np.outer(*weights)
    return table * outer, moduli.max() * outer


@cache
def mode_cases(seed: int) -> list[tuple[list[Case], Array, Array, float, float]]:
    """Return cases of `scatter`, their values, scale, error of the quadrature, and condition."""
    rng = np.random.default_rng([seed, 2])
    made = []
    for family in ("white", "cov"):
        for kind in KINDS:
            unit = 10.0 ** rng.uniform(-6, 1)
            r, phi = autocorrelation(rng, kind, unit), rng.normal(size=2) / unit
            large = 10.0 ** rng.uniform(-3, 3)
            theta = large**2 * covariance(rng, 0.3, 1.5)
            w = turn(rng.uniform(0, 7)) @ np.linalg.cholesky(np.linalg.inv(theta)).T
            # V = WB has singular values near 1 per unit
            b = np.linalg.inv(w) @ root(rng, 0.4, 0.9) / unit
            sums = white_sums if family == "white" else covariant_sums
            shape = w if family == "white" else theta
            (values, scale), (second, _) = (sums(r, shape, b, phi, unit, h) for h in STEPS)
            inputs = {"R": r, "family": family, "shape": shape, "B": b, "phi": phi}
            cases = [
                ("scatter", {**inputs, "n": n, "m": m})
                for n in range(ORDER + 1)
                for m in range(ORDER + 1)
            ]
            condition = np.linalg.cond(w) * np.linalg.cond(b)
            made.append((cases, values, scale, (abs(values - second) / scale).max(), condition))
    return made


def modes(program: Program, seed: int) -> Rows:
    """F{R Ψ(B·)}(φ) for every mode with orders up to 5, over both families."""
    for cases, values, scale, error, condition in mode_cases(seed):
        found = program.values(cases).reshape(values.shape)
        inputs = cases[0][1]
        # φ·x and y of up to 60, rounded and multiplied by a gradient below √(2·10 + 2)
        bound = 100 * STEP * EPS * np.sqrt(4 * ORDER + 2) * condition
        name = f"{inputs['family']}, {inputs['R']['kind']}"
        yield f"F{{R Ψ(B·)}}(φ), {name}", (abs(found - values) / scale).max(), bound
        yield "  the quadrature by itself", error, bound / 2
