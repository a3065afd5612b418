"""Orders of gratings: the grating equation, amplitudes by FFT, and how they share the light."""

from functools import cache
from typing import Any

import numpy as np
from common import Array
from evaluate import Case, Program
from light_grids import EPS, Rows, largest

Spec = dict[str, Any]
SAMPLES = 2**13
SWEEPS = 4000


def heights(profile: Spec, x: Array) -> Array:
    """Return the heights at fractions x of the pitch, 0 ≤ x < 1."""
    depth = profile["depth"]
    if profile["kind"] == "sinusoidal":
        return 0.5 * depth * np.cos(2 * np.pi * x)
    if profile["kind"] == "lamellar":
        return np.where(np.abs((x + 0.5) % 1 - 0.5) < 0.5 * profile["ridge_fraction"], depth, 0)
    if profile["kind"] == "blazed":
        return depth * (x if profile["sense"] == "rising" else 1 - x)
    apex = profile["apex"]
    return depth * np.where(x < apex, x / apex, (1 - x) / (1 - apex))


def amplitudes(profile: Spec, phi_z: float, orders: Array, samples: int = SAMPLES) -> Array:
    """Return t_q of these orders by FFT: midpoints, extrapolated from three numbers of them.

    Edges of all profiles here are between samples, so the error goes by even powers of the step.
    """

    def midpoints(n: int) -> Array:
        t = np.fft.fft(np.exp(-1j * phi_z * heights(profile, (np.arange(n) + 0.5) / n))) / n
        return t[orders % n] * np.exp(-1j * np.pi * orders / n)

    first, second, third = (midpoints(samples * 2**i) for i in range(3))
    second, third = second + (second - first) / 3, third + (third - second) / 3
    return third + (third - second) / 15


def lattice(inputs: Spec) -> tuple[Array, Array]:
    """Return G and the tangential part of n_i i, over k₀."""
    g = inputs["lambda"] / inputs["pitch"] * np.array(inputs["across"])
    return g, inputs["n_incident"] * np.array(inputs["to_source"][:2])


def propagating(centre: Array, g: Array, index: float) -> Array:
    """Return the orders q with |centre + qG| < index."""
    q = np.arange(-60, 61)
    return q[np.hypot(*(centre[:, None] + q * g[:, None])) < index]


def cosines(centre: Array, g: Array, orders: Array, index: float) -> Array:
    """Return the cosines of orders in a medium."""
    return np.sqrt(1 - (np.hypot(*(centre[:, None] + orders * g[:, None])) / index) ** 2)


def expected(inputs: Spec) -> dict[str, Array]:
    """Return all that `grating` does."""
    g, given = lattice(inputs)
    n_i, n_o = inputs["n_incident"], inputs["n_outgoing"]
    side = 1.0 if inputs["side"] == "reflection" else -1.0
    k0 = 2 * np.pi / inputs["lambda"]
    q = propagating(-given, g, n_o)
    cos_o = cosines(-given, g, q, n_o)
    o = np.column_stack([(-given[:, None] + q * g[:, None]).T / n_o, side * cos_o])
    # the directions that are coupled to the same orders
    m = propagating(given, g, n_i)
    cos_i = cosines(given, g, m, n_i)
    table = np.empty((len(m), len(q)), complex)
    for row, c_i in enumerate(cos_i):
        for column, c_o in enumerate(cos_o):
            phi_z = k0 * (n_i * c_i + side * n_o * c_o)
            order = np.array([m[row] + q[column]])
            table[row, column] = amplitudes(inputs["profile"], phi_z, order)[0]
    here = int(np.flatnonzero(m == 0)[0])
    p = np.abs(table) ** 2
    cap = np.maximum(1, np.maximum(p[here].sum(), p.sum(0)))
    made = {
        "orders": np.column_stack([q, 0 * q]),
        "to_observer": o,
        "phi_z": k0 * (n_i * cos_i[here] + side * n_o * cos_o),
        "amplitude": table[here],
        "share": p[here],
        "efficiency": p[here] / cap,
    }
    if len(m) == len(q):
        for _ in range(SWEEPS):
            p = p / p.sum(1, keepdims=True)
            p = p / p.sum(0)
        made["lossless"] = p[here]
    return made


@cache
def cases(seed: int) -> list[tuple[Case, dict[str, Array]]]:
    """Return random gratings in random, conical mounts."""
    rng = np.random.default_rng([seed, 21])
    made = []
    for kind in ("sinusoidal", "lamellar", "blazed", "triangular"):
        for side in ("reflection", "transmission", "reflection"):
            wavelength = rng.uniform(4e-7, 7e-7)
            profile = {"kind": kind, "depth": rng.uniform(0.05, 0.9) * wavelength}
            profile |= {
                "lamellar": {"ridge_fraction": rng.integers(10, 54) / 64},
                "blazed": {"sense": str(rng.choice(["rising", "falling"]))},
                "triangular": {"apex": rng.integers(10, 54) / 64},
            }.get(kind, {})
            turn, azimuth = rng.uniform(0, 2 * np.pi, 2)
            sin = rng.uniform(0, 0.9)
            into = 1.0 if side == "reflection" else 1.5
            inputs = {
                "profile": profile,
                "pitch": rng.uniform(1.2, 6) * wavelength,
                "across": [np.cos(turn), np.sin(turn)],
                "to_source": [sin * np.cos(azimuth), sin * np.sin(azimuth), np.sqrt(1 - sin * sin)],
                "lambda": wavelength,
                "side": side,
                "n_incident": 1.0,
                "n_outgoing": into,
            }
            made.append((("grating", inputs), expected(inputs)))
    return made


def orders(program: Program, seed: int) -> Rows:
    """Every order's number, direction, wave vector, amplitude and efficiencies."""
    plan = cases(seed)
    results = program([case for case, _ in plan])
    # cosines lose digits toward grazing: ε/cos² there; amplitudes have ψ ≤ 12 rad
    least = min(np.abs(want["to_observer"][:, 2]).min() for _, want in plan)
    rounding = 64 * EPS / least**2
    bounds = {
        "orders": 0.0,
        "to_observer": rounding,
        "phi_z": rounding,
        # and what is left of the midpoint rule, (ψ/2^13)^6
        "amplitude": 16 * rounding + 1e-13,
        "share": 32 * rounding + 2e-13,
        "efficiency": 32 * rounding + 2e-13,
    }
    for key, bound in bounds.items():
        error = []
        for (case, want), result in zip(plan, results, strict=True):
            found = np.array(result[key])
            k0 = 2 * np.pi / case[1]["lambda"]
            scale = k0 if key == "phi_z" else 1.0
            same = found.shape == want[key].shape
            error.append(np.abs(found - want[key]).max() / scale if same else np.inf)
        yield f"gratings, {key}", largest(error), bound
    error, count = [], 0
    for (_, want), result in zip(plan, results, strict=True):
        if "lossless" in result and "lossless" in want:
            count += 1
            error.append(np.abs(np.array(result["lossless"]) - want["lossless"]).max())
            error.append(abs(sum(result["lossless"]) - 1))
    # sums are 1 to 1e-12 and the factors follow them, worse where they hardly meet
    yield f"gratings, lossless ({count} of {len(plan)})", largest(error), 1e-9
    yield "  gratings without lossless efficiencies", len(plan) - count, len(plan) - 4


def asymmetric_lobes(program: Program, seed: int) -> Rows:
    """`lobe` of orders with signs: F{R} is p_q at φ = qG and not at −qG."""
    rng = np.random.default_rng([seed, 22])
    plan, want = [], []
    for _ in range(8):
        g, width = rng.normal(size=2) * 3e6, rng.uniform(3e-6, 9e-6)
        weights = rng.uniform(0, 1, 5)
        listed = [[int(q), p] for q, p in zip(range(-2, 3), weights, strict=True)]
        phi = g * rng.integers(-2, 3) + rng.normal(size=2) / width
        r = {"kind": "orders", "S": width**2 * np.eye(2), "G": g, "orders": listed}
        plan.append(("lobe", {"R": r, "phi": phi}))
        lines = [p * np.exp(-0.5 * width**2 * ((phi - q * g) @ (phi - q * g))) for q, p in listed]
        want.append(2 * np.pi * width**2 * sum(lines))
    found, peak = program.values(plan), 2 * np.pi * 81e-12
    # exponents of up to 400 rounded
    yield "lobes of signed orders", np.abs(found - np.array(want)).max() / peak, 1e-13
