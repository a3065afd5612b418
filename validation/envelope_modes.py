"""Writes crates/stokes/tests/data/envelope_modes.csv: modes of profiles by plain quadrature.

    validation/.venv/bin/python validation/envelope_modes.py

    s_ab = (-1)^(a+b) 2 pi |det W|^(-1/2) Int I(x) h_a(y1) h_b(y2) d2x,     y = W^-T P' (x - mean)

Panels of Gauss-Legendre nodes over cells and rings, the trapezoidal rule over Gaussians, in
extended precision; W^-T P' with 50 digits for the given binary64 P and W, or for the exact
Cov^(1/2) P where a line says `native`.  One line a case: kind; numbers of the profile; P;
`native` or W; order; W; coefficients.
"""

import random
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import mpmath as mp
import numpy as np

OUT = Path(__file__).resolve().parent.parent / "crates/stokes/tests/data/envelope_modes.csv"
LD = np.longdouble
Array = np.ndarray
mp.mp.dps = 50


def hermite(order: int, t: np.ndarray) -> np.ndarray:
    """h_0 ... h_order, by the recurrence in extended precision."""
    h = np.zeros((order + 1, *t.shape), LD)
    h[0] = LD(np.pi) ** LD(-0.25) * np.exp(-t * t / 2)
    pi_error = LD("3.1415926535897932384626433832795") ** LD(-0.25) / LD(np.pi) ** LD(-0.25)
    h[0] *= pi_error
    if order:
        h[1] = np.sqrt(LD(2)) * t * h[0]
    for n in range(1, order):
        h[n + 1] = np.sqrt(LD(2) / (n + 1)) * t * h[n] - np.sqrt(LD(n) / (n + 1)) * h[n - 1]
    return h


def legendre(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre nodes and weights, polished by Newton in extended precision."""
    x = np.polynomial.legendre.leggauss(n)[0].astype(LD)
    for _ in range(2):
        p0, p1 = np.ones_like(x), x.copy()
        for k in range(2, n + 1):
            p0, p1 = p1, ((2 * k - 1) * x * p1 - (k - 1) * p0) / k
        slope = n * (x * p1 - p0) / (x * x - 1)
        x = x - p1 / slope
    p0, p1 = np.ones_like(x), x.copy()
    for k in range(2, n + 1):
        p0, p1 = p1, ((2 * k - 1) * x * p1 - (k - 1) * p0) / k
    slope = n * (x * p1 - p0) / (x * x - 1)
    return x, 2 / ((1 - x * x) * slope * slope)


NODES = legendre(32)


def ld(x: mp.mpf) -> LD:
    """A number of many digits in extended precision."""
    return LD(mp.nstr(mp.mpf(x), 25))


def accumulate(total: Array, order: int, t: Array, points: Array, weights: Array) -> None:
    """Add weighted values of all products h_a h_b at these points."""
    y = points @ t.T
    near = (np.abs(y) < np.sqrt(2 * order + 1) + 12).all(-1)
    if not near.any():
        return
    y, weights = y[near], weights[near]
    first, second = hermite(order, y[:, 0]), hermite(order, y[:, 1])
    total += (first * weights) @ second.T


def panels(low: LD, high: LD, t_column: Array, order: int) -> list:
    """Edges so that each panel has a modest phase."""
    phase = (
        (np.sqrt(2 * order + 1) + 9)
        * float(np.linalg.norm(np.array(t_column, float)))
        * float(high - low)
    )
    count = max(1, int(np.ceil(phase / 12)))
    return [low + (high - low) * LD(i) / count for i in range(count + 1)]


def cells(
    total: Array, order: int, t: Array, columns: list, rows: list, samples: Array | list
) -> None:
    """A grid of cells; columns and rows are the edges about the centroid."""
    node, weight = NODES
    reach = np.sqrt(2 * order + 1) + 12
    for j in range(len(rows) - 1):
        for i in range(len(columns) - 1):
            v = samples[j][i]
            if v == 0:
                continue
            ex = panels(columns[i], columns[i + 1], t[:, 0], order)
            ey = panels(rows[j], rows[j + 1], t[:, 1], order)
            for x0, x1 in pairwise(ex):
                for y0, y1 in pairwise(ey):
                    corners = np.array([[x, y] for x in (x0, x1) for y in (y0, y1)]) @ t.T
                    if (corners.min(0) > reach).any() or (corners.max(0) < -reach).any():
                        continue
                    gx, gy = (
                        (x0 + x1) / 2 + (x1 - x0) / 2 * node,
                        (y0 + y1) / 2 + (y1 - y0) / 2 * node,
                    )
                    points = np.stack(np.meshgrid(gx, gy, indexing="ij"), -1).reshape(-1, 2)
                    w = np.outer(weight * (x1 - x0) / 2, weight * (y1 - y0) / 2).ravel()
                    accumulate(total, order, t, points, LD(v) * w)


def disk(total: Array, order: int, t: Array, radius: LD) -> None:
    """Rings of nodes in the radius, the trapezoidal rule in the angle."""
    node, weight = NODES
    extent = float(np.linalg.norm(np.array(t, float), 2)) * float(radius)
    phase = (np.sqrt(2 * order + 1) + 9) * extent
    rings = max(1, int(np.ceil(phase / 10)))
    angles = int(2 * phase) + 120
    theta = LD("6.283185307179586476925286766559") * np.arange(angles).astype(LD) / angles
    for k in range(rings):
        r0, r1 = radius * LD(k) / rings, radius * LD(k + 1) / rings
        r = (r0 + r1) / 2 + (r1 - r0) / 2 * node
        w = weight * (r1 - r0) / 2 * r * (LD("6.283185307179586476925286766559") / angles)
        points = np.stack([np.outer(r, np.cos(theta)), np.outer(r, np.sin(theta))], -1).reshape(
            -1, 2
        )
        accumulate(total, order, t, points, np.repeat(w, angles))


def gaussian(total: Array, order: int, t: Array, peak: float, centre: list, cov: mp.matrix) -> None:
    """x = centre + L g, the trapezoidal rule over g with a step that resolves both factors."""
    l11 = mp.sqrt(cov[0, 0])
    l21 = cov[1, 0] / l11
    l22 = mp.sqrt(cov[1, 1] - l21**2)
    root = np.array([[ld(l11), LD(0)], [ld(l21), ld(l22)]])
    tl = t @ root
    smallest = 1 / (
        1 + float(np.linalg.norm(np.array(tl, float), 2)) * 1.2 * np.sqrt(2 * order + 1) / 3
    )
    step = LD(min(0.2, 0.5 * smallest))
    g = np.arange(int(-11 / step) - 1, int(11 / step) + 2).astype(LD) * step
    for row in g:
        points = np.stack([np.full_like(g, row), g], -1)
        w = LD(peak) * ld(l11 * l22) * step * step * np.exp(-(row * row + g * g) / 2)
        accumulate(total, order, t, points @ root.T + np.array(centre), w)


def matrix(values: list[float]) -> mp.matrix:
    """2 x 2, row by row."""
    a, b, c, d = values
    return mp.matrix([[mp.mpf(a), mp.mpf(b)], [mp.mpf(c), mp.mpf(d)]])


def moments_of(kind: str, p: list[float]) -> tuple[list, mp.matrix]:
    """Centroid and covariance, in many digits."""
    m = mp.mpf
    if kind == "rectangle":
        return [mp.mpf(0)] * 2, mp.matrix([[m(p[0]) ** 2 / 3, 0], [0, m(p[1]) ** 2 / 3]])
    if kind == "disk":
        return [mp.mpf(0)] * 2, mp.eye(2) * (m(p[0]) ** 2 / 4)
    pieces = []
    if kind == "mixture":
        for q in range(0, len(p), 7):
            cov = matrix(p[q + 3 : q + 7])
            mass = 2 * mp.pi * m(p[q]) * mp.sqrt(mp.det(cov))
            pieces.append((mass, [m(p[q + 1]), m(p[q + 2])], cov))
    else:
        nx, px, py, cx, cy, *samples = p
        nx = int(nx)
        ny = len(samples) // nx
        inner = mp.matrix([[m(px) ** 2 / 12, 0], [0, m(py) ** 2 / 12]])
        for k, v in enumerate(samples):
            i, j = k % nx, k // nx
            place = [
                m(cx) + (i + mp.mpf(1 - nx) / 2) * m(px),
                m(cy) + (j + mp.mpf(1 - ny) / 2) * m(py),
            ]
            pieces.append((m(v), place, inner))
    whole = mp.fsum(w for w, _, _ in pieces)
    centre = [mp.fsum(w * c[a] for w, c, _ in pieces) / whole for a in range(2)]
    cov = mp.zeros(2, 2)
    for w, c, inner in pieces:
        d = mp.matrix([c[0] - centre[0], c[1] - centre[1]])
        cov += (inner + d * d.T) * w / whole
    return centre, cov


def root_of(cov: mp.matrix) -> mp.matrix:
    """The symmetric root."""
    s = mp.sqrt(mp.det(cov))
    return (cov + s * mp.eye(2)) / mp.sqrt(cov[0, 0] + cov[1, 1] + 2 * s)


def edges(count: int, size: float, middle: LD) -> list:
    """The edges of a row of cells."""
    return [middle + (LD(i) - LD(count) / 2) * LD(size) for i in range(count + 1)]


def text(values: Iterable) -> str:
    """Numbers as their shortest binary64 text."""
    return " ".join(repr(float(v)) for v in values)


def case(
    kind: str, p: list[float], projection: list[float], w: list[float] | None, order: int
) -> str:
    """One line of the table."""
    centre, cov = moments_of(kind, p)
    pm = matrix(projection)
    wm = root_of(cov) * pm if w is None else matrix(w)
    t_mp = (pm * wm**-1).T
    t = np.array([[ld(t_mp[i, j]) for j in range(2)] for i in range(2)])
    total = np.zeros((order + 1, order + 1), LD)
    origin = [ld(c) for c in centre]
    if kind == "rectangle":
        cells(total, order, t, [-LD(p[0]), LD(p[0])], [-LD(p[1]), LD(p[1])], [[1.0]])
    elif kind == "disk":
        disk(total, order, t, LD(p[0]))
    elif kind == "mixture":
        for q in range(0, len(p), 7):
            place = [LD(p[q + 1]) - origin[0], LD(p[q + 2]) - origin[1]]
            gaussian(total, order, t, p[q], place, matrix(p[q + 3 : q + 7]))
    else:
        nx, px, py, cx, cy, *samples = p
        ny = len(samples) // int(nx)
        columns = edges(int(nx), px, LD(cx) - origin[0])
        rows = edges(ny, py, LD(cy) - origin[1])
        cells(total, order, t, columns, rows, np.array(samples).reshape(ny, int(nx)))
    scale = LD("6.283185307179586476925286766559") / np.sqrt(abs(ld(mp.det(wm))))
    s = [(-1) ** n * scale * total[n - b, b] for n in range(order + 1) for b in range(n + 1)]
    shown = "native" if w is None else text(w)
    return ";".join([kind, text(p), text(projection), shown, str(order), text(wm), text(s)])


def profiles(rng: random.Random) -> dict[str, list[float]]:
    """One profile of each kind."""

    def cov(condition: float) -> list[float]:
        c, s = np.cos(a := rng.uniform(0, 3)), np.sin(a)
        q = np.array([[c, -s], [s, c]])
        m = q @ np.diag([1.0, 1 / condition]) @ q.T * rng.uniform(0.5, 2)
        return [float(m[0, 0]), float(m[0, 1]), float(m[0, 1]), float(m[1, 1])]

    grid = [float(round(rng.uniform(0, 1), 3)) * (rng.random() > 0.2) for _ in range(12)]
    return {
        "rectangle": [rng.uniform(0.3, 2), rng.uniform(0.3, 2)],
        "disk": [rng.uniform(0.3, 2)],
        "mixture": [1.0, 0.3, -0.2, *cov(3), 0.4, -0.9, 0.5, *cov(8)],
        "sampled": [4, 0.3, 0.5, 0.1, -0.2, *grid],
    }


def turn(a: float) -> np.ndarray:
    """A rotation."""
    return np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])


def thin(rng: random.Random, condition: float) -> list[float]:
    """A projection of this condition number."""
    a, b = rng.uniform(0, 3), rng.uniform(0, 3)
    return [float(v) for v in (turn(a) @ np.diag([1.0, 1 / condition]) @ turn(b)).ravel()]


def main() -> None:
    """Write the table."""
    rng = random.Random(1)
    lines = [
        "# written by validation/envelope_modes.py: "
        "kind; profile; P; native or W; order; W; (-i)^(a+b) mu_ab"
    ]
    for kind, p in profiles(rng).items():
        _, cov = moments_of(kind, p)
        lines.append(case(kind, p, [1.0, 0.0, 0.0, 1.0], None, 12))
        for condition, order in ((3, 24), (1e6, 8)):
            projection = thin(rng, condition)
            lines.append(case(kind, p, projection, None, order))
            # another root: the native one, stretched and turned on the left
            for spread in (1.0, 6.0):
                left = np.array(thin(rng, spread)).reshape(2, 2) * rng.uniform(0.4, 1.5)
                native = root_of(cov) * matrix(projection)
                w = mp.matrix(left.tolist()) * native
                lines.append(case(kind, p, projection, [float(v) for v in w], 10))
        print(kind, flush=True)
    OUT.parent.mkdir(parents=True, exist_ok=True)
    OUT.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
