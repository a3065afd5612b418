"""Openings in a screen: sums over points of the source, and integrals over the openings."""

from functools import cache
from typing import Any

import numpy as np
from common import Array
from evaluate import Case, Program
from light_grids import EPS, Rows, largest
from numpy.polynomial.hermite_e import hermegauss
from numpy.polynomial.legendre import leggauss
from scipy.special import j1

Spec = dict[str, Any]
PAULI = np.array(
    [[[1, 0], [0, 1]], [[1, 0], [0, -1]], [[0, 1], [1, 0]], [[0, -1j], [1j, 0]]], complex
)
NODES = 40


def source(light: Spec, nodes: int) -> tuple[Array, Array]:
    """Return points u of the source and their weights, of sum 1."""
    if light["kind"] == "plane_wave":
        return np.zeros((1, 2)), np.ones(1)
    if light["kind"] == "disk":
        x, weight = leggauss(nodes)
        radius = np.sqrt(0.5 + 0.5 * x)
        turn = 2 * np.pi * np.arange(2 * nodes) / (2 * nodes)
        u = np.stack([np.outer(radius, np.cos(turn)), np.outer(radius, np.sin(turn))], -1)
        return u.reshape(-1, 2), np.repeat(0.5 * weight / (2 * nodes), 2 * nodes)
    x, weight = hermegauss(nodes) if light["kind"] == "gaussian" else leggauss(nodes)
    weight = weight / weight.sum()
    u = np.stack(np.meshgrid(x, x, indexing="ij"), -1).reshape(-1, 2)
    return u, np.outer(weight, weight).ravel()


def transform(opening: Spec, kappa: Array, nodes: int) -> Array:
    """Return ∫ exp(−iκ·x) d²x over an opening, by Gauss-Legendre in both directions."""
    x, weight = leggauss(nodes)
    product = np.exp(-1j * kappa @ opening["centre"])
    for axis, side in enumerate(("width", "height")):
        half = 0.5 * opening[side]
        product = product * half * (np.exp(-1j * half * np.outer(kappa[:, axis], x)) @ weight)
    return product


def expected(inputs: Spec, nodes: int) -> Array:
    """Return 1/(λ² A_s) Σ p M(Σ T_n F_n(φ + q)*) for each observer."""
    k0 = 2 * np.pi / inputs["lambda"]
    u, weight = source(inputs["light"], nodes)
    q = k0 * u @ np.array(inputs["light"].get("angles", np.zeros((2, 2)))).T
    made = []
    for o in inputs["to_observers"]:
        kappa = k0 * (o + inputs["to_source"])[:2] + q
        fields = [np.conj(transform(opening, kappa, nodes)) for opening in inputs["openings"]]
        jones = [np.array(opening["T"]) for opening in inputs["openings"]]
        t = sum(f[:, None, None] * j for f, j in zip(fields, jones, strict=True))
        m = np.einsum("lba,pac,jcd,pbd->plj", PAULI, t, PAULI, t.conj()).real / 2
        made.append(np.einsum("p,plj->lj", weight, m))
    return np.array(made) / (inputs["lambda"] ** 2 * inputs["screen_area"])


def coherence(inputs: Spec) -> float:
    """Return γ between the first two openings, in closed form (Van Cittert and Zernike)."""
    light = inputs["light"]
    if light["kind"] == "plane_wave":
        return 1.0
    apart = inputs["openings"][0]["centre"] - inputs["openings"][1]["centre"]
    y = 2 * np.pi / inputs["lambda"] * np.array(light["angles"]).T @ apart
    if light["kind"] == "disk":
        return float(2 * j1(np.hypot(*y)) / np.hypot(*y))
    if light["kind"] == "gaussian":
        return float(np.exp(-0.5 * y @ y))
    return float(np.prod(np.sinc(y / np.pi)))


@cache
def cases(seed: int) -> dict[str, list[tuple[Case, Array, Array]]]:
    """Return random slits by kind of light, with the matrices of two numbers of nodes."""
    rng = np.random.default_rng([seed, 31])
    made: dict[str, list[tuple[Case, Array, Array]]] = {}
    for kind in ("plane_wave", "gaussian", "rectangle", "disk"):
        made[kind] = []
        for number in range(6):
            openings = []
            for place in range(2 + number % 3):
                delay = np.exp(-1j * rng.uniform(0, 6))
                filling = rng.normal(size=(2, 2, 2)) @ [1, 1j] * 0.4 if number % 2 else np.eye(2)
                openings.append(
                    {
                        "centre": np.array([1e-4 * place, 2e-5 * rng.normal()]),
                        "width": rng.uniform(1e-5, 5e-5),
                        "height": rng.uniform(1e-5, 5e-5),
                        "T": filling * (delay if number % 2 else 1) + 0j,
                    }
                )
            light: Spec = {"kind": kind}
            if kind != "plane_wave":
                light["angles"] = rng.normal(size=(2, 2)) * 1e-3
            toward = []
            for _ in range(4):
                x, y = 0.02 * rng.normal(size=2)
                toward.append(np.array([x, y, np.sqrt(1 - x * x - y * y)]))
            x, y = 0.02 * rng.normal(size=2)
            inputs = {
                "openings": openings,
                "screen_area": 1e-7,
                "to_source": np.array([x, y, -np.sqrt(1 - x * x - y * y)]),
                "to_observers": toward,
                "lambda": rng.uniform(4e-7, 7e-7),
                "light": light,
                "tolerance": 1e-12,
                "pair": [0, 1],
            }
            pair = [expected(inputs, nodes) for nodes in (NODES, NODES + 9)]
            made[kind].append((("slits", inputs), *pair))
    return made


def transfers(program: Program, seed: int) -> Rows:
    """M of slits toward each observer, γ, visibility and what is open."""
    for kind, plan in cases(seed).items():
        results = program([case for case, *_ in plan])
        error, own, gammas, fringes, fractions = [], [], [], [], []
        for (case, first, second), result in zip(plan, results, strict=True):
            inputs = case[1]
            openings, screen = inputs["openings"], inputs["screen_area"]
            area = sum(o["width"] * o["height"] for o in openings)
            largest_jones = max(np.linalg.norm(o["T"], 2) for o in openings)
            scale = (area * largest_jones) ** 2 / (inputs["lambda"] ** 2 * screen)
            error.append(np.abs(np.array(result["M"]) - first).max() / scale)
            own.append(np.abs(second - first).max() / scale)
            fractions.append(abs(result["open_fraction"] - area / screen))
            gammas.append(abs(result["gamma"] - coherence(inputs)))
            fringes.append(fringe_error(inputs, result))
        # the tolerance, and phases k θ x of up to 300 rad rounded
        bound = 2e-12 + 300 * 8 * EPS
        yield f"M of slits, {kind}", largest(error), bound
        yield "  the quadrature by itself", largest(own), bound / 2
        yield "  γ of the first two", largest(gammas), bound
        yield "  their visibility", largest(fringes), 2 * bound
        yield "  open fraction", largest(fractions), 8 * EPS


def fringe_error(inputs: Spec, result: dict[str, Any]) -> float:
    """Compare the visibility with (max − min)/(max + min) of unpolarized light."""
    k0, off = 2 * np.pi / inputs["lambda"], 0.0
    gamma = abs(coherence(inputs))
    for o, found in zip(inputs["to_observers"], result["visibility"], strict=True):
        kappa = k0 * (o + inputs["to_source"])[None, :2]
        a, b = (
            transform(opening, kappa, NODES)[0].conj() * np.array(opening["T"])
            for opening in inputs["openings"][:2]
        )
        powers = np.linalg.norm(a) ** 2 + np.linalg.norm(b) ** 2
        off = max(off, abs(found - 2 * gamma * abs(np.vdot(b, a)) / powers))
    return off
