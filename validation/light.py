"""Brewster's Hermite-Gauss light against quadrature of the definitions.

Values come from `brewster eval`; what they are held to is computed here by quadrature, contour
integrals, numerical differentiation and sampled fields (numpy, scipy, mpmath).  Every bound is the
rounding of both sides: a few ε = 2^-52 times the sum of moduli that the quadrature adds up, times
the condition number by which rounded inputs move the whitened coordinates y = Wx.  Each trapezoid
rule here is of an analytic function that decays like a Gaussian; its own error is below ε.
"""

import sys
from typing import Any

import light_functions
import light_sources
import light_space
import numpy as np
from common import Report
from evaluate import Case, Program, check

CHECKS = [
    light_functions.orthonormal_on_the_line,
    light_functions.orthonormal_in_the_plane,
    light_functions.biorthogonal,
    light_functions.generating_function,
    light_functions.fourier_pair,
    light_functions.parity,
    light_sources.transforms,
    light_sources.projections,
    light_sources.shapes,
    light_functions.overlaps,
    light_functions.symmetric_powers,
    light_functions.same_function,
    light_space.coherence,
    light_space.observables,
]


def scaled(value: Any, factor: complex) -> Any:  # noqa: ANN401
    """Return `value`, every number of it times `factor`."""
    if isinstance(value, list):
        return [scaled(entry, factor) for entry in value]
    if isinstance(value, dict):
        return {key: scaled(entry, factor) for key, entry in value.items()}
    return value * factor


def odd_flipped(case: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Give functions of odd total order the other sign."""
    _, inputs = case
    first, second = inputs.get("a", inputs.get("n", 0)), inputs.get("b", inputs.get("m", 0))
    alone = "value" in result and "W2" not in inputs and (first + second) % 2
    return scaled(result, -1) if alone else result


def two_pi_off(case: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Use another convention of the Fourier transform."""
    op, _ = case
    if op == "ft_psi":
        return scaled(result, 1 / (2 * np.pi))
    if op == "projection":
        return {**result, "white": scaled(result["white"], 1 / (2 * np.pi))}
    return {**result, "W": result["W"] * 2 * np.pi} if op == "wvd" else result


def conjugated(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Conjugate every complex number."""
    return {
        key: np.conj(value) if isinstance(value, complex) else value
        for key, value in result.items()
    }


def transposed(case: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Return the symmetric power of the transpose."""
    op, _ = case
    return {"matrix": np.array(result["matrix"]).T} if op == "sym_power" else result


def turned_left(case: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Take the other sense of rotation."""
    return {**result, "chi": -result["chi"]} if case[0] == "observables" else result


def rounded(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Keep single precision only."""

    def narrow(value: Any) -> Any:  # noqa: ANN401
        if isinstance(value, list):
            return [narrow(entry) for entry in value]
        return (
            complex(np.complex64(value)) if isinstance(value, complex) else float(np.float32(value))
        )

    with np.errstate(all="ignore"):
        return {key: narrow(value) for key, value in result.items()}


FALSIFIED = [odd_flipped, two_pi_off, conjugated, transposed, turned_left, rounded]


def compare(program: Program) -> Report:
    """Run every check."""
    report = Report("Hermite-Gauss light (largest error, relative to what its quadrature adds up)")
    for chapter in CHECKS:
        for what, error, bound in chapter(program):
            report.within(what, float(error), float(bound))
    return report


if __name__ == "__main__":
    sys.exit(check(__doc__, compare, FALSIFIED))
