"""Random autocorrelations, envelopes, light and directions, and what they are by definition.

Lengths are in units of one length L, near a micrometre, so that everything is near 1.
"""

from typing import Any

import numpy as np
from common import Array
from hermite_gauss import hermite_table
from light_grids import modes, turn

Spec = dict[str, Any]
Generator = np.random.Generator
KINDS = ("constant", "gaussian", "gaussian_sum", "grating", "rough")


def covariance(rng: Generator, low: float, high: float) -> Array:
    """Return a symmetric matrix with random axes and eigenvalues between these."""
    axes = turn(rng.uniform(0, np.pi))
    made = axes @ np.diag(rng.uniform(low, high, 2)) @ axes.T
    made[1, 0] = made[0, 1]
    return made


def root(rng: Generator, low: float, high: float) -> Array:
    """Return a matrix with random axes on both sides, singular values between these."""
    left, right = turn(rng.uniform(0, 7)), turn(rng.uniform(0, 7))
    return left @ np.diag(rng.uniform(low, high, 2)) @ right @ np.diag([1, rng.choice([-1, 1])])


def autocorrelation(rng: Generator, kind: str, unit: float) -> Spec:
    """Return an autocorrelation that is no narrower than the length `unit` or so."""
    area = unit * unit
    amp = complex(*rng.normal(size=2)) if rng.random() < 0.25 else float(rng.normal())
    spec: Spec = {"kind": kind, "amp": [amp.real, amp.imag] if isinstance(amp, complex) else amp}
    match kind:
        case "gaussian":
            spec |= {"S": area * covariance(rng, 1.5, 4.0)}
        case "gaussian_sum":
            shapes = [area * covariance(rng, 1.5, 4.0) for _ in range(3)]
            spec |= {"weights": rng.normal(size=3), "S_list": shapes}
        case "grating":
            spec |= {"S": area * covariance(rng, 1.5, 6.0), "orders": rng.normal(size=3)}
            spec |= {"G": rng.normal(size=2) * 0.5 / unit}
        case "rough":
            spec |= {"g": rng.uniform(0.2, 1.5), "l": unit * rng.uniform(2.0, 3.0)}
    return spec


def quadratic(s: Array, x: Array) -> Array:
    """Return x'S⁻¹x."""
    return np.einsum("...i,ij,...j->...", x, np.linalg.inv(s), x)


def without_decay(r: Spec) -> complex:
    """Return R far away."""
    amp = r.get("amp", 1.0)
    amp = complex(*amp) if isinstance(amp, list) else amp
    return {"constant": amp, "rough": amp * np.exp(-r.get("g", 0.0))}.get(r["kind"], 0.0)


def value(r: Spec, x: Array) -> Array:
    """Return R(x), x [..., 2]."""
    amp = r.get("amp", 1.0)
    amp = complex(*amp) if isinstance(amp, list) else amp
    match r["kind"]:
        case "constant":
            return amp * np.ones(x.shape[:-1])
        case "gaussian":
            return amp * np.exp(-0.5 * quadratic(r["S"], x))
        case "gaussian_sum":
            parts = zip(r["weights"], r["S_list"], strict=True)
            return amp * np.sum([w * np.exp(-0.5 * quadratic(s, x)) for w, s in parts], 0)
        case "grating":
            phase = x @ r["G"]
            orders = np.sum([a * np.cos(q * phase) for q, a in enumerate(r["orders"])], 0)
            return amp * np.exp(-0.5 * quadratic(r["S"], x)) * orders
        case _:
            return amp * np.exp(r["g"] * np.expm1(-np.square(x).sum(-1) / r["l"] ** 2))


def footprint(i: Spec, x: Array) -> Array:
    """Return I(x) of a Gaussian or a mixture, x [..., 2]."""
    if i["kind"] == "gaussian":
        return np.exp(-0.5 * quadratic(i["S"], x))
    parts = zip(i["weights"], i["S_list"], strict=True)
    return np.sum([w * np.exp(-0.5 * quadratic(s, x)) for w, s in parts], 0)


def series(w: Array, named: list[list[Any]], x: Array) -> Array:
    """Return Σ c_ab φ_ab(x; W), x [..., 2]."""
    y = x @ w.T
    order = max(max(a, b) for a, b, _ in named)
    h0, h1 = hermite_table(order, y[..., 0]), hermite_table(order, y[..., 1])
    size = np.sqrt(abs(np.linalg.det(w)))
    return size * np.sum([c * h0[a] * h1[b] for a, b, c in named], 0)


def hermitian_modes(rng: Generator, order: int) -> list[list[Any]]:
    """Return modes [a, b, c], c real for even orders and imaginary for odd ones."""
    return [
        [a, b, complex(rng.normal()) * 1j ** ((a + b) % 2) * 0.6 ** (a + b)]
        for a, b in modes(order)
    ]


def across(direction: Array, rng: Generator) -> Array:
    """Return two axes, as rows, right-handed about a direction and turned at random."""
    helper = np.eye(3)[np.argmin(np.abs(direction))]
    first = np.cross(helper, direction)
    first /= np.linalg.norm(first)
    return turn(rng.uniform(0, 2 * np.pi)) @ np.array([first, np.cross(direction, first)])


def encounter(rng: Generator, envelope: str) -> tuple[Spec, float]:
    """Return the inputs of `interaction`, and the length that everything is near to."""
    wavelength, unit = rng.uniform(3.8e-7, 7.8e-7), rng.uniform(2e-6, 6e-6)
    k = 2 * np.pi / wavelength
    s, r = rng.uniform(0.5, 50.0, 2)
    # directions in the axes of a surface that lies anywhere; the lobe is a few 1/L wide
    theta, azimuth = rng.uniform(0.0, 1.2), rng.uniform(0, 2 * np.pi)
    incident = np.sin(theta) * np.array([np.cos(azimuth), np.sin(azimuth)])
    leaving = rng.normal(size=2) * 0.7 / (k * unit) - incident
    local = [np.append(d, np.sqrt(1 - d @ d)) for d in (incident, leaving)]
    placed = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    placed *= np.sign(np.linalg.det(placed))
    to_source, to_observer = (placed @ d for d in local)
    t = placed[:, :2].T
    e_in, e_out = across(to_source, rng), across(to_observer, rng)
    b = k / s * e_in @ t.T
    light = root(rng, 0.45, 0.8) / unit @ np.linalg.inv(b)
    separations = np.vstack([np.zeros(2), rng.normal(size=(2, 2))]) * r / (k * unit)
    channels = [
        [
            autocorrelation(rng, KINDS[rng.integers(5)], unit) if rng.random() < 0.8 else None
            for _ in range(4)
        ]
        for _ in range(4)
    ]
    return {
        "lambda": wavelength,
        "s": s,
        "r": r,
        "to_source": to_source,
        "to_observer": to_observer,
        "t": t,
        "e_in": e_in,
        "e_out": e_out,
        "incident": {"W": light, "modes": [hermitian_modes(rng, 3) for _ in range(4)]},
        "R": channels,
        "I": profile(rng, envelope, unit),
        "N_out": 6,
        "xi": separations,
    }, unit


def profile(rng: Generator, kind: str, unit: float) -> Spec:
    """Return an envelope not far from the length `unit`."""
    area = unit * unit
    match kind:
        case "gaussian":
            return {"kind": kind, "S": area * covariance(rng, 0.5, 0.8)}
        case "gaussian_mixture":
            shapes = [area * covariance(rng, 0.5, 0.8) for _ in range(2)]
            return {"kind": kind, "weights": rng.uniform(0.3, 1.0, 2), "S_list": shapes}
        case "rect":
            hx, hy = unit * rng.uniform(0.7, 1.8, 2)
            return {"kind": kind, "hx": hx, "hy": hy}
        case _:
            return {"kind": kind, "radius": unit * rng.uniform(0.7, 1.8)}


def map_of(inputs: Spec) -> tuple[Array, Array, Array]:
    """Return B, φ and P of an encounter."""
    k = 2 * np.pi / inputs["lambda"]
    t, e_in, e_out = inputs["t"], inputs["e_in"], inputs["e_out"]
    phi = k * t @ (inputs["to_observer"] + inputs["to_source"])
    return k / inputs["s"] * e_in @ t.T, phi, t @ e_out.T
