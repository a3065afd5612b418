"""Rough surfaces: lobes by Hankel transforms, facets by Fresnel and tmm, energy by sums."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import optics
import tmm
from common import Array
from evaluate import Case, Program
from light_grids import EPS, Rows, largest
from numpy.polynomial.legendre import leggauss
from scipy.special import erfc, gamma, j0, kv

Correlation = Callable[[Array], Array]
Spec = dict[str, Any]
# panels and nodes of two rules over the radius
RULES = ((60, 24), (83, 17))
Z = np.array([0.0, 0.0, 1.0])


def height_correlation(relief: Spec) -> Correlation:
    """Return ρ of the heights of a relief, a function of the distance."""
    if relief["kind"] == "gaussian":
        return lambda r: np.exp(-((r / relief["l"]) ** 2))
    if relief["kind"] == "exponential":
        return lambda r: np.exp(-r / relief["l"])
    nu = relief["exponent"] - 1
    # Matérn's function, 1 at 0
    return lambda r: 2 ** (1 - nu) / gamma(nu) * (r / relief["l"]) ** nu * kv(nu, r / relief["l"])


def hankel(f: Callable[[Array], Array], end: float, q: float, rule: tuple[int, int]) -> float:
    """Return 2π ∫ f(r) J₀(qr) r dr to `end`, in panels that narrow toward 0 as cubes."""
    panels, nodes = rule
    x, weight = leggauss(nodes)
    s = ((np.arange(panels)[:, None] + 0.5 + 0.5 * x) / panels).ravel()
    weight = np.tile(0.5 * weight / panels, panels) * 3 * s**2 * end
    r = end * s**3
    return float(2 * np.pi * np.sum(weight * f(r) * j0(q * r) * r))


def diffuse(relief: Spec, g: float, q: float, spread: float, rule: tuple[int, int]) -> float:
    """Return the lobe of e^(−g(1−ρ)) − e^(−g) at q for light of γ = e^(−spread² r²/2)."""
    rho = height_correlation(relief)
    end = {"gaussian": 6.5, "exponential": 45.0, "k_correlation": 50.0}[relief["kind"]]

    def f(r: Array) -> Array:
        c = rho(r)
        # e^(−g(1−ρ)) − e^(−g) without cancellation where ρ is small
        low = np.exp(-g) * np.expm1(np.minimum(g * c, 1.0))
        high = np.exp(-g * (1 - c)) - np.exp(-g)
        return np.where(g * c < 1, low, high) * np.exp(-0.5 * (spread * r) ** 2)

    return hankel(f, end * relief["l"], q, rule)


@cache
def lobe_cases(seed: int) -> list[tuple[Case, Array, float, float]]:
    """Return cases of `lobe` with both rules' values, the peak and the tolerance."""
    rng = np.random.default_rng([seed, 11])
    made = []
    plan = [("gaussian", g, 1e-15) for g in (1e-3, 0.1, 1.0, 3.0, 30.0, 400.0, 1e4)]
    plan += [("exponential", g, 1e-6) for g in (0.1, 1.0, 5.0, 30.0)]
    plan += [("k_correlation", g, 1e-5) for g in (0.1, 1.0, 5.0)]
    for kind, g, tolerance in plan:
        # over x and y in units of the lengths the lobe is round
        lengths = rng.uniform(1, 9, 2) * 1e-6
        relief = {"kind": kind, "sigma": 10.0 ** rng.uniform(-9, -6), "l": 1.0}
        if kind == "k_correlation":
            relief["exponent"] = rng.uniform(1.6, 3.0)
        phi_z = np.sqrt(g) / relief["sigma"]
        area = lengths[0] * lengths[1]
        peak = area * diffuse(relief, g, 0.0, 0.0, RULES[0])
        width = 2 * np.sqrt(1 + g)
        for place in (0.0, 0.4, 1.0, 2.0):
            turned = rng.uniform(0, 2 * np.pi)
            phi = place * width * np.array([np.cos(turned), np.sin(turned)]) / lengths
            values = [area * diffuse(relief, g, place * width, 0.0, rule) for rule in RULES]
            given = {**relief, "l": lengths}
            r = {"kind": "relief", "relief": given, "phi_z": phi_z, "tolerance": tolerance}
            made.append((("lobe", {"R": r, "phi": phi}), np.array(values), peak, tolerance))
    return made


def lobes(program: Program, seed: int) -> Rows:
    """F{R} of normally distributed heights, over its peak, and the coherent weight."""
    cases = lobe_cases(seed)
    results = program([case for case, *_ in cases])
    for kind in ("gaussian", "exponential", "k_correlation"):
        mine = [
            (case, values, peak, tolerance, result)
            for (case, values, peak, tolerance), result in zip(cases, results, strict=True)
            if case[1]["R"]["relief"]["kind"] == kind
        ]
        error = [abs(result["value"] - v[0]) / peak for _, v, peak, _, result in mine]
        # 2000 nodes of like sign, and a Bessel function of up to 300 rad
        bound = largest(tolerance for *_, tolerance, _ in mine) + 300 * EPS * 8
        yield f"F{{R}}(φ) of heights, {kind}, over the peak", largest(error), bound
        second = largest(abs(v[1] - v[0]) / peak for _, v, peak, *_ in mine)
        yield "  the quadrature by itself", second, bound / 2
        off = []
        for case, *_, result in mine:
            r = case[1]["R"]
            weight = np.exp(-((r["phi_z"] * r["relief"]["sigma"]) ** 2))
            off.append(abs(result["coherent_weight"] - weight))
        # (φ_z σ)² of up to 1e4 is rounded, where the weight is nothing
        yield "  coherent weight", largest(off), 8 * EPS


# ---------------------------------------------------------------- facets


def unit(v: Array) -> Array:
    """Return `v` at length 1."""
    return v / np.linalg.norm(v)


def turned(k: Array, x: Array, other: Array) -> float:
    """Return the angle from axis `x` to axis `other`, counter-clockwise against the ray k."""
    y = np.cross(k, x)
    return float(np.arctan2(other @ y, other @ x))


def facet_mueller(boundary: Spec, cos: float, into: float | None, wavelength: float) -> Array:
    """Return the matrix of a facet in s and p; `into` is the index behind, for transmission."""
    n1, n2 = boundary["n_front"], boundary["n_back"]
    if boundary["kind"] == "film":
        n = [n1, *(index for index, _ in boundary["layers"]), n2]
        thickness = [np.inf, *(d for _, d in boundary["layers"]), np.inf]
        # tmm's fields go as exp(−iωt)
        angle = np.arccos(cos)
        parts = [tmm.coh_tmm(p, np.conj(n), thickness, angle, wavelength) for p in "sp"]
        if into is None:
            return optics.from_amplitudes(*(np.conj(part["r"]) for part in parts))
        cos2 = optics.cos_refracted(n1, n2, cos).real
        power = np.sqrt(n2 * cos2 / (n1 * cos))
        return optics.from_amplitudes(*(power * np.conj(part["t"]) for part in parts))
    both = optics.reflection_amplitudes if into is None else optics.transmission_amplitudes
    return optics.from_amplitudes(*both(n1, n2, cos))


def facet(inputs: Spec, indices: tuple[float, float]) -> tuple[Array, Array]:
    """Return M(h) between the s-p frames about the surface's normal, and k₀ (n_o o + n_i i)."""
    i, o = inputs["to_source"], inputs["to_observer"]
    phi = 2 * np.pi / inputs["lambda"] * (indices[1] * o + indices[0] * i)
    h = unit(phi) * np.sign(phi[2])
    if h @ i <= 0 or (h @ o) * o[2] <= 0:
        return np.zeros((4, 4)), phi
    s = unit(np.cross(h, -i))
    into = None if o[2] > 0 else indices[1]
    m = facet_mueller(inputs["boundary"], float(h @ i), into, inputs["lambda"])
    # between frames (s, k × s) of the facet and (normal × k, …) of the surface
    x_in, x_out = unit(np.cross(Z, -i)), unit(np.cross(Z, o))
    to_facet, from_facet = turned(-i, x_in, s), turned(o, s, x_out)
    return optics.rotation(from_facet) @ m @ optics.rotation(to_facet), phi


def shadowing(inputs: Spec) -> float:
    """Return Smith's G1(i) G1(o) for the Gaussian slopes of the heights."""
    relief, product = inputs["relief"], 1.0
    alpha = 2 * relief["sigma"] / relief["l"]
    for v in (inputs["to_source"], inputs["to_observer"]):
        a = abs(v[2]) / (alpha * np.hypot(v[0], v[1]))
        product /= 1 + 0.5 * (np.exp(-a * a) / (a * np.sqrt(np.pi)) - erfc(a))
    return product


def expected_function(inputs: Spec, indices: tuple[float, float], rule: tuple[int, int]) -> Array:
    """Return n_o²/λ² O F{R γ}(φ_t) M(h)."""
    m, phi = facet(inputs, indices)
    i, o, relief = inputs["to_source"], inputs["to_observer"], inputs["relief"]
    g = (phi[2] * relief["sigma"]) ** 2
    spread = 2 * np.pi * indices[0] / inputs["lambda"] * inputs["light"]["angles"]
    lobe = diffuse(relief, g, float(np.hypot(phi[0], phi[1])), spread, rule)
    factor = (indices[1] / inputs["lambda"]) ** 2
    if inputs["obliquity"]:
        factor *= abs((i @ phi) * (o @ phi)) / (abs(i[2] * o[2]) * phi[2] ** 2)
    if inputs["shadowing"]:
        factor *= shadowing(inputs)
    return factor * lobe * m


def towards(rng: np.random.Generator, sign: float) -> Array:
    """Return a random direction not within 8° of the surface."""
    cos, azimuth = rng.uniform(0.14, 0.999), rng.uniform(0, 2 * np.pi)
    sin = np.sqrt(1 - cos * cos)
    return np.array([sin * np.cos(azimuth), sin * np.sin(azimuth), sign * cos])


@cache
def facet_cases(seed: int) -> dict[str, list[tuple[Case, Array, Array]]]:
    """Return cases of `surface` by kind, with the matrices of both rules."""
    rng = np.random.default_rng([seed, 12])
    layers = [(1.38, 9e-8), (2.1 - 0.3j, 4e-8)]
    kinds = {
        "dielectric, reflection": ({"kind": "dielectric", "n_front": 1.0, "n_back": 1.5}, 1.0),
        "from glass, total too": ({"kind": "dielectric", "n_front": 1.5, "n_back": 1.0}, 1.0),
        "dielectric, transmission": ({"kind": "dielectric", "n_front": 1.0, "n_back": 1.5}, -1.0),
        "conductor": ({"kind": "conductor", "n_front": 1.0, "n_back": 0.183 - 3.43j}, 1.0),
        "films on metal": (
            {"kind": "film", "n_front": 1.0, "layers": layers, "n_back": 1.1 - 6.8j},
            1.0,
        ),
        "film, transmission": (
            {"kind": "film", "n_front": 1.0, "layers": layers[:1], "n_back": 1.5},
            -1.0,
        ),
    }
    made: dict[str, list[tuple[Case, Array, Array]]] = {}
    for what, (boundary, side) in kinds.items():
        made[what] = []
        while len(made[what]) < 16:
            wavelength = rng.uniform(4e-7, 7e-7)
            inputs = {
                "boundary": boundary,
                "relief": {
                    "kind": "gaussian",
                    "sigma": rng.uniform(0.02, 1.0) * wavelength,
                    "l": rng.uniform(1, 5) * wavelength,
                },
                "to_source": towards(rng, 1.0),
                "to_observer": towards(rng, side),
                "lambda": wavelength,
                "light": {"kind": "gaussian", "angles": rng.choice([1e-9, 0.1])},
                "obliquity": int(rng.uniform() < 0.8),
                "shadowing": int(rng.uniform() < 0.3),
            }
            indices = (boundary["n_front"], boundary["n_back"] if side < 0 else boundary["n_front"])
            pair = [expected_function(inputs, indices, rule) for rule in RULES]
            # facets that are seen, and what is more than rounding of the sum over the radius
            if pair[0][0, 0] > 1e-6:
                made[what].append((("surface", inputs), *pair))
    return made


def facets(program: Program, seed: int) -> Rows:
    """M of a rough boundary in every direction: obliquity, half vector, light, shadowing."""
    for what, cases in facet_cases(seed).items():
        results = program([case for case, *_ in cases])
        own, error = [], []
        for (case, first, second), result in zip(cases, results, strict=True):
            # over what the lobe's peak would be here
            scale = first[0, 0] * peak_over(case[1], result)
            error.append(np.abs(np.array(result["M"]) - first).max() / scale)
            own.append(np.abs(second - first).max() / scale)
        # rounding of 2000 nodes, some ε each, and of the facet
        bound = 3000 * EPS
        yield f"M of rough surfaces over the peak, {what}", largest(error), bound
        yield "  the quadrature by itself", largest(own), bound / 2


def peak_over(inputs: Spec, result: dict[str, Any]) -> float:
    """Return the lobe's peak over its value here."""
    g = (result["phi_z"] * inputs["relief"]["sigma"]) ** 2
    k = 2 * np.pi / inputs["lambda"] * inputs["boundary"]["n_front"]
    spread = k * inputs["light"]["angles"]
    q = float(np.hypot(*result["phi_t"]))
    here, peak = (diffuse(inputs["relief"], g, at, spread, RULES[0]) for at in (q, 0.0))
    return abs(peak / here)


# ---------------------------------------------------------------- energy


def half_sphere(side: float, azimuths: int, angles: int) -> tuple[Array, Array]:
    """Return directions on one side, y ≥ 0, and their weights cos θ dω of the whole half."""
    x, weight = leggauss(angles)
    theta = 0.25 * np.pi * (x + 1)
    turn = np.pi * (np.arange(azimuths) + 0.5) / azimuths
    sin, cos = np.sin(theta), np.cos(theta)
    directions = np.stack(
        [np.outer(sin, np.cos(turn)), np.outer(sin, np.sin(turn)), side * np.outer(cos, turn**0)],
        -1,
    )
    rings = 0.25 * np.pi * weight * sin * cos * 2 * np.pi / azimuths
    return directions.reshape(-1, 3), np.repeat(rings, azimuths)


def energy(program: Program, seed: int) -> Rows:
    """What a lossless height surface sends out: mirror and diffuse light together are 1 ± 3e-4.

    The obliquity factor conserves energy for gentle heights, α = 2σ/l ≤ 0.1 and l ≥ 2λ, up to 30°.
    """
    del seed
    wavelength = 5e-7
    for kind, side, length, degrees in (
        ("mirror", 1.0, 2.0, 0.0),
        ("mirror", 1.0, 2.0, 30.0),
        ("mirror", 1.0, 5.0, 30.0),
        ("window", -1.0, 5.0, 30.0),
    ):
        directions, weights = half_sphere(side, 32, 64)
        angle = np.radians(degrees)
        inputs = {
            "boundary": {"kind": kind},
            "relief": {"kind": "gaussian", "sigma": 0.05 * length * wavelength},
            "to_source": np.array([np.sin(angle), 0.0, np.cos(angle)]),
            "lambda": wavelength,
            "n_outgoing": 1.0 if side > 0 else 1.5,
        }
        inputs["relief"]["l"] = length * wavelength
        results = program([("surface", {**inputs, "to_observer": o}) for o in directions])
        f = np.array([result["M"][0][0] for result in results])
        # of the directions, one whose beam is the mirror's or Snell's
        beams = results[0]["beams"]
        sharp = sum(beam["weight"] * beam["M"][0][0] for beam in beams)
        total = float(weights @ f) + sharp
        what = f"{kind}, α = 0.1, l = {length:g} λ, {degrees:g}°"
        yield f"energy out of a {what}, less 1", abs(total - 1), 3e-4
