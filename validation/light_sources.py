"""Envelopes of incoherent sources: projections against quadrature, shapes against derivatives."""

from typing import Any

import numpy as np
from common import Array
from evaluate import Program
from hermite_gauss import hermite_table
from light_grids import EPS, STEP, Rows, grid, largest, moved, shape
from mpmath import mp
from scipy.special import j1

ENVELOPES: dict[str, dict[str, Any]] = {
    "rectangle": {"kind": "rect", "hx": 1.3, "hy": 0.4},
    "disk": {"kind": "disk", "radius": 0.9},
    "Gaussian": {"kind": "gaussian", "S": shape(1.5, 0.3, 0.4)},
    "mixture": {
        "kind": "gaussian_mixture",
        "weights": [0.7, 1.9],
        "S_list": [shape(1.5, 0.3, 0.4), shape(0.5, 0.2, -1.0)],
    },
}
TILTED = np.array([[0.36, -0.54], [0.02, 1.32]])


def sinc(x: Array) -> Array:
    """Return sin(x)/x."""
    return np.sinc(x / np.pi)


def transform(envelope: dict[str, Any], u: Array) -> Array:
    """Return F{I}(u) for u [P,2]: elementary transforms, checked by `transforms` below."""
    match envelope["kind"]:
        case "rect":
            hx, hy = envelope["hx"], envelope["hy"]
            return 4 * hx * hy * sinc(u[:, 0] * hx) * sinc(u[:, 1] * hy)
        case "disk":
            a = envelope["radius"]
            q = np.maximum(np.hypot(u[:, 0], u[:, 1]) * a, 1e-12)
            return 2 * np.pi * a * a * j1(q) / q
        case "gaussian":
            s = envelope["S"]
            quadratic = np.einsum("pi,ij,pj->p", u, s, u)
            return 2 * np.pi * np.sqrt(np.linalg.det(s)) * np.exp(-0.5 * quadratic)
        case _:
            parts = zip(envelope["weights"], envelope["S_list"], strict=True)
            return np.sum([w * transform({"kind": "gaussian", "S": s}, u) for w, s in parts], 0)


def matter_points(envelope: dict[str, Any]) -> tuple[Array, Array]:
    """Return points [P,2] and weights of ∫ I(x) … d²x over the plane of the envelope."""
    t, w = np.polynomial.legendre.leggauss(60)
    match envelope["kind"]:
        case "rect":
            half = np.array([envelope["hx"], envelope["hy"]])
            x = np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2) * half
            return x, np.outer(w, w).ravel() * half.prod()
        case "disk":
            a = envelope["radius"]
            r, angle = a * (t + 1) / 2, np.arange(120) * np.pi / 60
            x = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))], -1)
            return x.reshape(-1, 2), np.repeat(w / 2 * a * r * np.pi / 60, 120)
        case "gaussian":
            y, weight = grid(8.8, 0.3)
            s = np.linalg.cholesky(envelope["S"])
            return y @ s.T, weight * np.linalg.det(s) * np.exp(-0.5 * (y**2).sum(-1))
        case _:
            parts = [matter_points({"kind": "gaussian", "S": s}) for s in envelope["S_list"]]
            weights = [k * w for k, (_, w) in zip(envelope["weights"], parts, strict=True)]
            return np.concatenate([x for x, _ in parts]), np.concatenate(weights)


def covariance(envelope: dict[str, Any]) -> Array:
    """Return ∫ x x' I d²x / ∫ I d²x by quadrature."""
    x, weight = matter_points(envelope)
    return np.einsum("p,pi,pj->ij", weight, x, x) / weight.sum()


def symmetric_root(m: Array) -> Array:
    """Return the positive root of a symmetric matrix."""
    values, vectors = np.linalg.eigh(m)
    return (vectors * np.sqrt(values)) @ vectors.T


def projections(program: Program) -> Rows:
    """μ_ab = ∫ F{I}(Pw) φ_ab(w; W) d²w by quadrature over w, and what comes with it."""
    straight = np.eye(2)
    other = np.array([[0.9, 0.2], [-0.4, 1.1]])
    setups = [("", straight, None, 32), (", tilted", TILTED, None, 16)]
    setups.append((", tilted, other W", TILTED, other, 12))
    for kind, envelope in ENVELOPES.items():
        for suffix, p, w, order in setups:
            inputs: dict[str, Any] = {"I": envelope, "P": p, "N": order}
            if w is None:
                w = symmetric_root(covariance(envelope)) @ p
            else:
                inputs["W"] = w
            [found] = program([("projection", inputs)])
            yield from projection_errors(f"{kind}{suffix}", found, envelope, p, w, order)


def projection_errors(
    name: str, found: dict[str, Any], envelope: dict[str, Any], p: Array, w: Array, order: int
) -> Rows:
    """Compare one result of `projection` with quadrature."""
    # h_32 ends at 14; F{I} has frequencies below √3 per whitened unit, 5 with the other W
    y, weight = grid(14.0, 0.2)
    side = round(np.sqrt(len(y)))
    h = hermite_table(order, y[:side, 1])
    f = transform(envelope, y @ np.linalg.inv(w).T @ p.T).reshape(side, side)
    jacobian = weight / np.sqrt(abs(np.linalg.det(w)))
    mu = jacobian * h @ f @ h.T
    scale = jacobian * np.abs(f).sum() * h.max() ** 2
    # the rounding of the quadrature and of W; y = W^-T P'x moves with cond W
    bound = moved(np.array(2.0), order) * np.linalg.cond(w)
    white = largest(
        abs(found["white"][n][b] - mu[n - b, b]) for n in range(order + 1) for b in range(n + 1)
    )
    yield f"⟨F{{I}}|φ⟩, {name}, N = {order}", white / scale, bound
    area = matter_points(envelope)[1].sum()
    given = np.array(found["W"])
    theta = np.linalg.inv(w.T @ w)
    rest = largest(
        abs(found["f0"] / area - 1),
        np.abs(given - w).max() / np.abs(w).max(),
        np.abs(np.array(found["Theta"]) - theta).max() / np.abs(theta).max(),
    )
    yield f"  its W, Θ and F{{I}}(0), {name}", rest, STEP * EPS * 4 * np.linalg.cond(w) ** 2


def transforms(_: Program) -> Rows:
    """The transforms that the projections use are ∫ I(x) exp(−iu·x) d²x."""
    u = np.random.default_rng(4).normal(scale=3.0, size=(40, 2))
    for kind, envelope in ENVELOPES.items():
        x, weight = matter_points(envelope)
        expected = weight @ np.exp(-1j * x @ u.T)
        error = np.abs(transform(envelope, u) - expected).max() / weight.sum()
        yield f"(this script) F{{I}}, {kind}", error, 64 * EPS


def logarithm(envelope: dict[str, Any], p: Array, a: Any, b: Any) -> Any:  # noqa: ANN401
    """Return ln|F{I}(P(a, b))|, with as many digits as mpmath is set to."""
    u = [p[i][0] * a + p[i][1] * b for i in (0, 1)]
    match envelope["kind"]:
        case "rect":
            factors = [mp.sinc(u[0] * envelope["hx"]), mp.sinc(u[1] * envelope["hy"])]
            return sum(mp.log(abs(v)) for v in factors)
        case "disk":
            q = mp.sqrt(u[0] ** 2 + u[1] ** 2) * envelope["radius"]
            return mp.log(abs(2 * mp.besselj(1, q) / q)) if q else mp.mpf(0)
        case "gaussian":
            return -sum(u[i] * envelope["S"][i][j] * u[j] for i in (0, 1) for j in (0, 1)) / 2
        case _:
            total = mp.mpf(0)
            for k, s in zip(envelope["weights"], envelope["S_list"], strict=True):
                quadratic = sum(u[i] * s[i][j] * u[j] for i in (0, 1) for j in (0, 1))
                size = mp.sqrt(mp.mpf(s[0][0]) * s[1][1] - mp.mpf(s[0][1]) ** 2)
                total += k * size * mp.exp(-quadratic / 2)
            return mp.log(total)


def shapes(program: Program) -> Rows:
    """Θ⁻¹ = −∂²ln|F{I}(Pw)| at 0, differentiated by mpmath."""
    for suffix, p in (("", np.eye(2)), (", tilted", TILTED)):
        for kind, envelope in ENVELOPES.items():
            [found] = program([("shape", {"I": envelope, "P": p})])
            with mp.workdps(60):
                plain = {
                    key: [np.array(s).tolist() for s in v] if key == "S_list" else v
                    for key, v in envelope.items()
                }

                def f(a: Any, b: Any, plain: Any = plain, p: Any = p) -> Any:  # noqa: ANN401
                    return logarithm(plain, p.tolist(), a, b)

                second = [mp.diff(f, (0, 0), n) for n in ((2, 0), (1, 1), (0, 2))]
            hessian = -np.array([[second[0], second[1]], [second[1], second[2]]], float)
            theta = np.linalg.inv(hessian)
            error = largest(
                np.abs(np.array(found["minus_hessian"]) - hessian).max() / np.abs(hessian).max(),
                np.abs(np.array(found["Theta"]) - theta).max() / np.abs(theta).max(),
            )
            bound = STEP * EPS * np.linalg.cond(hessian)
            yield f"Hessian of ln|F{{I}}|, {kind}{suffix}", error, bound
