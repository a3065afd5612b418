"""Shapes, grids and the size of rounding: what the checks of `light.py` share."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from common import Array

EPS = 2.0**-52
# what each step of an evaluation may lose, in ε: products, sums and one function call
STEP = 8
Rows = Iterator[tuple[str, float, float]]


def largest(*values: Any) -> float:  # noqa: ANN401
    """Return the largest of numbers and iterables of numbers; NaN if one is NaN, unlike `max`."""
    flat = [v for value in values for v in (value if hasattr(value, "__iter__") else [value])]
    return float(np.max(flat))


def turn(angle: float) -> Array:
    """Return the rotation by `angle`."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def root(large: float, small: float, angle: float, left: float = 0.0) -> Array:
    """Return a root W with these singular values; its rows are turned by `left`."""
    return turn(left) @ np.diag([large, small]) @ turn(angle)


def shape(large: float, small: float, angle: float) -> Array:
    """Return Θ with these eigenvalues, exactly symmetric."""
    theta = turn(angle) @ np.diag([large, small]) @ turn(-angle)
    theta[1, 0] = theta[0, 1]
    return theta


def modes(order: int) -> list[tuple[int, int]]:
    """Return the pairs of orders with a + b ≤ order."""
    return [(n - b, b) for n in range(order + 1) for b in range(n + 1)]


def gauss_grid(points: int) -> tuple[Array, Array]:
    """Return points [P,2] and weights of a rule for polynomials times exp(−|y|²)."""
    t, w = np.polynomial.hermite.hermgauss(points)
    y = np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2)
    return y, np.outer(w, w).ravel() * np.exp((y**2).sum(-1))


def grid(extent: float, step: float) -> tuple[Array, float]:
    """Return points [P,2] of a square trapezoid rule and the weight of each."""
    t = np.arange(-round(extent / step), round(extent / step) + 1) * step
    return np.stack(np.meshgrid(t, t, indexing="ij"), -1).reshape(-1, 2), step * step


ROOTS = {
    "round": np.eye(2),
    "cond Θ 1e2, turned": root(3.0, 0.3, 0.6, 1.9),
    "cond Θ 1e8, turned": root(1e3, 0.1, -0.4, 0.3),
    "mirrored": root(2.0, 0.7, 0.8) @ np.diag([1.0, -1.0]),
    "0.1 mm, cond Θ 25": 1e-4 * root(1.0, 0.2, 1.2, -0.7),
}
SHAPES = {
    "round": np.eye(2),
    "cond 30": shape(6.0, 0.2, 0.5),
    "cond 1e4": shape(3e7, 3e3, -1.1),
}


def moved(y: Array, order: int) -> float:
    """Return what rounded coordinates do to a function of this order, at condition number 1.

    |y| moves by a few ε|y|, the function by its gradient, whose norm is below √(2N+2).
    """
    return STEP * EPS * (np.abs(y).max() * np.sqrt(2 * order + 2) + order + 1)
