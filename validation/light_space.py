"""Light in space: coherence, Wigner function and observables against quadrature and fields."""

from typing import Any

import numpy as np
from evaluate import Program
from hermite_gauss import from_generating_function
from light_grids import EPS, STEP, Rows, grid, largest, moved, shape, turn

LIGHT: dict[str, dict[str, Any]] = {
    "even orders": {
        "lambda": 5.5e-7,
        "r": 2.0,
        "Theta": shape(1.6, 0.6, 0.4),
        "Q": turn(2.0),
        "modes": [[0, 0, 1.0 + 0j], [2, 0, -0.2 + 0j], [1, 1, 0.15 + 0j], [2, 2, 0.1 + 0j]],
    },
    "odd orders": {
        "lambda": 1e-3,
        "r": 7e3,
        "Theta": shape(40.0, 0.5, -0.9),
        "Q": turn(-0.5),
        "modes": [[0, 0, 0.8 + 0j], [1, 0, 0.3j], [0, 1, -0.2j], [2, 1, 0.1j], [0, 2, 0.2 + 0j]],
    },
    "far infrared, thin": {
        "lambda": 1e-5,
        "r": 1e6,
        "Theta": shape(3e4, 3.0, 1.2),
        "Q": turn(0.8),
        "modes": [[0, 0, 2.0 + 0j], [1, 0, 0.02j], [0, 3, -1e-5j], [1, 1, -3e-4 + 0j]],
    },
}


def coherence(program: Program) -> Rows:
    """C(ξ) from generating functions, W(ζ) as its numerical Fourier transform, and ∫W."""
    rng = np.random.default_rng(7)
    y, weight = grid(10.0, 0.5)
    for name, light in LIGHT.items():
        k, theta = 2 * np.pi / light["lambda"], light["Theta"]
        factor = np.linalg.cholesky(theta)
        # y = 1 where w = (k/r) Q ξ is one width of Θ
        to_xi = light["r"] / k * light["Q"].T @ factor
        xi = y @ to_xi.T
        c = program.values([("csd", {**light, "xi": p}) for p in xi], "C")
        condition = np.linalg.cond(theta)
        bound = moved(np.array(10.0), 4) * condition

        near = np.flatnonzero(np.abs(y).max(-1) < 3)[::9]
        error = 0.0
        for i in near:
            w = k / light["r"] * light["Q"] @ xi[i]
            table, scale = from_generating_function(4, theta, w, dual=False)
            expected = sum(v * table[n, m] for n, m, v in light["modes"]) / light["r"] ** 2
            most = sum(abs(v) * scale[n, m] for n, m, v in light["modes"]) / light["r"] ** 2
            error = largest(error, abs(c[i] - expected) / most)
        yield f"C(ξ), {name}", error, bound

        zeta = np.concatenate([rng.normal(size=(6, 2)), [[0, 0]]]) @ np.linalg.inv(to_xi)
        found = program.values([("wvd", {**light, "zeta": z}) for z in zeta], "W")
        area = weight * abs(np.linalg.det(to_xi))
        expected = area * c @ np.exp(-1j * xi @ zeta.T)
        error = np.abs(found - expected).max() / (area * np.abs(c).sum())
        yield f"W(ζ) = ∫ C(ξ) exp(−iζ·ξ) d²ξ, {name}", error, bound

        zeta = y @ np.linalg.inv(to_xi)
        results = program([("wvd", {**light, "zeta": z}) for z in zeta])
        wigner = np.array([result["W"] for result in results])
        area = weight / abs(np.linalg.det(to_xi)) / (2 * np.pi) ** 2
        intensity = results[0]["intensity"]
        centre = c[np.flatnonzero((y == 0).all(-1))[0]]
        error = largest(abs(area * wigner.sum() - intensity), abs(centre - intensity))
        yield f"(2π)⁻² ∫ W d²ζ = C(0), {name}", error / (area * np.abs(wigner).sum()), bound
        # light of Hermitian series has a real Wigner function
        worst = np.abs(wigner.imag).max() / np.abs(wigner).max()
        yield f"  imaginary part of W, {name}", worst, bound


def observables(program: Program) -> Rows:
    """Degrees, angles and ellipse from numpy's eigenvectors and a sampled field."""
    rng = np.random.default_rng(8)
    directions = rng.normal(size=(40, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    degrees = np.concatenate([rng.uniform(0, 1, 30), np.full(10, 1.0)])
    power = 10.0 ** rng.uniform(-12, 6, 40)
    states = np.concatenate([power[:, None], (power * degrees)[:, None] * directions], 1)
    found = program([("observables", {"stokes": s}) for s in states])
    # eigenvalues of the coherency matrix are good to ε·I, angles to ε over the part they belong to
    worst = {"degrees": 0.0, "axes of the ellipse": 0.0, "angles": 0.0, "eigenvalues": 0.0}
    for s, seen in zip(states, found, strict=True):
        coherency = 0.5 * np.array(
            [[s[0] + s[1], s[2] - 1j * s[3]], [s[2] + 1j * s[3], s[0] - s[1]]]
        )
        values, vectors = np.linalg.eigh(coherency)
        field = np.sqrt(values[1] - values[0]) * vectors[:, 1]
        # Re(E exp(iωt)) over one period; |E|² is a mean and one harmonic
        wt = 2 * np.pi * np.arange(64) / 64
        samples = (field[:, None] * np.exp(1j * wt)).real
        square = (samples**2).sum(0)
        mean, harmonic = square.mean(), 2 * np.mean(square * np.exp(-2j * wt))
        major = np.sqrt(mean + abs(harmonic))
        longest = (field * np.exp(-0.5j * np.angle(harmonic))).real
        orientation = np.arctan2(longest[1], longest[0])
        x, y = samples
        # the polygon of 64 points on an ellipse covers 32 sin(π/32) ab, counter-clockwise if > 0
        product = np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / (64 * np.sin(np.pi / 32))
        minor = abs(product) / major
        sin2chi = -product / mean
        expected = {
            "degrees": {
                "DoP": (values[1] - values[0]) / s[0],
                "DoLP": 2 * abs(harmonic) / s[0],
                # opposite circular parts of the field
                "DoCP": (abs(field[0] - 1j * field[1]) ** 2 - abs(field[0] + 1j * field[1]) ** 2)
                / (2 * s[0]),
            },
            "axes of the ellipse": {"semi_major": major**2 / s[0], "semi_minor": minor**2 / s[0]},
        }
        seen = {**seen, **{key: seen[key] ** 2 / s[0] for key in ("semi_major", "semi_minor")}}
        for group, entries in expected.items():
            worst[group] = largest(
                worst[group], *(abs(seen[key] - v) for key, v in entries.items())
            )
        part = seen["DoLP"] / 4
        between = (seen["AoLP"] - orientation + np.pi / 2) % np.pi - np.pi / 2
        off = [abs(between) * part, abs(np.sin(2 * seen["chi"]) - sin2chi) * seen["DoP"]]
        inside = -np.pi / 2 < seen["AoLP"] <= np.pi / 2
        worst["angles"] = largest(worst["angles"], *off, 0.0 if inside else np.inf)
        error = np.abs(np.sort(seen["eig"]) - values).max() / s[0]
        worst["eigenvalues"] = largest(worst["eigenvalues"], error, abs(seen["I"] / s[0] - 1))
    for group, error in worst.items():
        yield f"{group}, of 40 states", error, 4 * STEP * EPS
