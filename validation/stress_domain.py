"""Inputs that must be refused, each by an error that names its case, and some that must not."""

from typing import Any

import numpy as np
from evaluate import Case

NAN, INFINITY = float("nan"), float("inf")
ONE = np.eye(2)
LIGHT: dict[str, Any] = {
    "lambda": 5e-7,
    "r": 2.0,
    "Theta": ONE,
    "Q": ONE,
    "modes": [[0, 0, 1.0 + 0j]],
}


def phi(w: Any, x: Any = (0.0, 0.0), a: int = 0, b: int = 0) -> Case:  # noqa: ANN401
    """Return a case of φ_ab(x; W)."""
    return ("phi", {"a": a, "b": b, "W": w, "x": list(x)})


def psi(theta: Any, n: int = 0, m: int = 0) -> Case:  # noqa: ANN401
    """Return a case of Ψ_nm at (0.1, 0.2)."""
    return ("psi", {"n": n, "m": m, "Theta": theta, "x": [0.1, 0.2], "dual": 0})


def projection(envelope: dict[str, Any], order: int = 2, p: Any = ONE) -> Case:  # noqa: ANN401
    """Return a case of the projection of an envelope."""
    return ("projection", {"I": envelope, "P": p, "N": order})


OUTSIDE: dict[str, Case] = {
    "h_n of NaN": ("hermite1d", {"n": 1, "t": NAN}),
    "h_257": ("hermite1d", {"n": 257, "t": 0.5}),
    "h_n of negative order": ("hermite1d", {"n": -1, "t": 0.5}),
    "h_n without argument": ("hermite1d", {"n": 1}),
    "singular root": phi([[1.0, 2.0], [2.0, 4.0]]),
    "root of zeros": phi(np.zeros((2, 2))),
    "root with cond Θ 1e30": phi(np.diag([1.0, 1e-15])),
    "root with NaN": phi([[1.0, NAN], [0.0, 1.0]]),
    "root with infinity": phi([[1.0, INFINITY], [0.0, 1.0]]),
    "root of 1e300": phi(1e300 * ONE),
    "φ at NaN": phi(ONE, (NAN, 0.0)),
    "φ of order 257": phi(ONE, (0.1, 0.1), 257, 0),
    "Θ not symmetric": psi([[2.0, 0.1], [0.5, 1.0]]),
    "Θ negative": psi(-ONE),
    "Θ indefinite": psi(np.diag([1.0, -1.0])),
    "Θ singular": psi([[1.0, 1.0], [1.0, 1.0]]),
    "Θ of zeros": psi(np.zeros((2, 2))),
    "Θ with cond 1e30": psi(np.diag([1e15, 1e-15])),
    "Θ with NaN": psi([[NAN, 0.0], [0.0, 1.0]]),
    "Θ of three rows": psi(np.eye(3)),
    "Ψ of order 257": psi(ONE, 257, 0),
    "Ψ(0), Θ negative": ("psi_zero", {"n": 0, "m": 0, "Theta": -ONE}),
    "F{Ψ} at NaN": ("ft_psi", {"n": 0, "m": 0, "Theta": ONE, "zeta": [NAN, 0.0], "dual": 0}),
    "overlap with singular root": (
        "overlap",
        {"a": 0, "b": 0, "n": 0, "m": 0, "W1": ONE, "W2": np.zeros((2, 2))},
    ),
    "Sym of order 257": ("sym_power", {"A": ONE, "N": 257}),
    "Sym of NaN": ("sym_power", {"A": NAN * ONE, "N": 2}),
    "coefficients over singular root": (
        "cov_to_white",
        {"W": np.zeros((2, 2)), "coeffs": [[1.0]]},
    ),
    "projection of order 257": projection({"kind": "disk", "radius": 1.0}, 257),
    "disk of radius 0": projection({"kind": "disk", "radius": 0.0}),
    "rectangle of negative width": projection({"kind": "rect", "hx": -1.0, "hy": 1.0}),
    "unknown envelope": projection({"kind": "triangle", "hx": 1.0}),
    "envelope seen edge-on": projection(
        {"kind": "disk", "radius": 1.0}, 2, np.array([[1.0, 0.0], [0.0, 0.0]])
    ),
    "shape of negative Gaussian": ("shape", {"I": {"kind": "gaussian", "S": -ONE}, "P": ONE}),
    "W at wavelength 0": ("wvd", {**LIGHT, "lambda": 0.0, "zeta": [0.0, 0.0]}),
    "C at negative distance": ("csd", {**LIGHT, "r": -2.0, "xi": [0.0, 0.0]}),
    "C at NaN": ("csd", {**LIGHT, "xi": [NAN, 0.0]}),
    "Stokes vector of three": ("observables", {"stokes": [1.0, 0.0, 0.0]}),
    "Stokes vector with NaN": ("observables", {"stokes": [1.0, NAN, 0.0, 0.0]}),
}

SOUND: list[Case] = [
    ("hermite1d", {"n": 256, "t": 0.5}),
    phi(np.diag([1.0, 1.01e-12]), (1.0, 1.0)),
    ("sym_power", {"A": ONE, "N": 2}),
    ("observables", {"stokes": [1.0, 0.0, 0.0, 0.5]}),
]
