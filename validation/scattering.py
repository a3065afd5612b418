"""Brewster's Theorem S4.1 against brute-force quadrature of the angular correlation transform.

    A{G}(p₁, p₂) = ∫∫ G(x₁, x₂) exp(−i(p₁·x₁ − p₂·x₂)) d²x₁ d²x₂
    G_l(x₁, x₂) = I((x₁+x₂)/2) Σ_j R^(j→l)(x₁−x₂) γ_j(x₁−x₂),   γ_j(x) = Σ c_ab φ_ab(Bx; W)/s²
    C_l(ξ) = A{G_l}(φ + κ/2, φ − κ/2)/(r²λ²),   φ = tangential part of k(r̂+ŝ),   κ = (k/r) P ξ

Values come from `brewster eval`: lobes, scattered modes and correlations of random encounters.
What they are held to is summed here by trapezoid and Gauss-Legendre rules over I, R and γ as they
are defined; the double integrals do not know that G is a product.  A seed makes the cases;
`--seed random` draws another one and prints it.

Differences are relative to the sum of moduli that a quadrature adds up.  The rules' own errors are
rows of their own, from a second grid of another step and place, and must stay below half the bound.
Bounds: of lobes the rounding, as `light.py` has it, times the condition number of W and B; of
double integrals 1e-10, since steps and ends of the 40⁴ points drop exp(−23) of Gaussians this wide.
"""

import sys
from typing import Any

import numpy as np
import scattering_lobes
import scattering_modes
import scattering_pairs
from common import Report
from evaluate import Case, Program, check

CHECKS = [
    scattering_lobes.modes,
    scattering_lobes.lobes,
    scattering_pairs.geometry,
    scattering_pairs.amplitudes,
    scattering_pairs.double_integrals,
    scattering_pairs.hard_edges,
    scattering_modes.projections,
    scattering_modes.shapes,
]


def _of(op: str, change: Any) -> Any:  # noqa: ANN401
    """Return a falsification of the results of one operation."""

    def tamper(case: Case, result: dict[str, Any]) -> dict[str, Any]:
        return {**result, **change(case[1], result)} if case[0] == op else result

    tamper.__name__ = change.__name__
    return tamper


def conjugated_lobes(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take the other sign of the kernel."""
    return {"value": np.conj(result["value"])}


def without_the_constant(inputs: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Forget what does not decay."""
    return {"coherent_weight": 0.0 * result["value"]}


def two_pi_off(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Use another convention of the Fourier transform."""
    return {"value": result["value"] / (2 * np.pi)}


def channels_transposed(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Mix up incident and outgoing parameters."""
    return {"A": np.array(result["A"]).T.tolist()}


def other_side(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take the other sign of the wave vector given to the matter."""
    return {"phi_t": [-x for x in result["phi_t"]]}


def map_transposed(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take the rows of B for its columns."""
    return {"B": np.array(result["B"]).T.tolist()}


def light_conjugated(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Exchange the two points."""
    return {"C_samples": np.conj(result["C_samples"])}


def without_the_distance(inputs: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Leave out 1/r²."""
    return {"C_samples": np.array(result["C_samples"]) * inputs["r"] ** 2}


def orders_exchanged(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take a for b in scattered modes."""
    return {"c_white": [[row[::-1] for row in rows] for rows in result["c_white"]]}


def shape_inverted(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take the covariance for the shape matrix."""
    return {"Theta_out": np.linalg.inv(result["Theta_out"]).tolist()}


def rounded(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Keep single precision only."""
    even = {key: value for key, value in result.items() if key not in ("c_white", "c_cov")}
    narrow = {key: np.asarray(value).astype(np.complex64) for key, value in even.items()}
    return result | {key: value.astype(complex).tolist() for key, value in narrow.items()}


FALSIFIED = [
    *(_of("scatter", change) for change in (conjugated_lobes, two_pi_off)),
    _of("lobe", without_the_constant),
    *(
        _of("interaction", change)
        for change in (
            channels_transposed,
            other_side,
            map_transposed,
            light_conjugated,
            without_the_distance,
            orders_exchanged,
            shape_inverted,
        )
    ),
    rounded,
]


def compare(program: Program, seed: int) -> Report:
    """Run every check on the cases of one seed."""
    report = Report(f"Light scattered by matter, seed {seed} (largest error, relative)")
    for chapter in CHECKS:
        for what, error, bound in chapter(program, seed):
            report.within(what, float(error), float(bound))
    return report


if __name__ == "__main__":
    sys.exit(check(__doc__, compare, FALSIFIED, seed=1))
