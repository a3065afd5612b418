"""Brewster's surfaces, gratings and slits against numpy, from the definitions.

    f = n_o²/λ² O F{(R − R(∞)) γ}(φ_t) M(h),    R = exp(−φ_z²σ²(1 − ρ)),   h = φ/|φ|
    t_q = (1/p) ∫ exp(−iφ_z h(x)) exp(−iqGx) dx,  n_o o_t = −n_i i_t + qG/k₀,   φ_z of each order
    f = 1/(λ²A) ∫ p(q) M(Σ T_n F_n(φ_t + q)*) d²q,   F_n(κ) = ∫ exp(−iκ·x) d²x over opening n

φ = k₀(n_o o + n_i i), O = |i·φ||o·φ|/(|i_z o_z|φ_z²).  Values come from `brewster eval`.  Here
lobes are Hankel transforms, facets are Fresnel's formulas in numpy and `tmm` (whose fields are
conjugated) between frames that are built anew, energy is a sum over the hemisphere, orders are FFTs
of the phase at each order's own φ_z, and slits are sums over points of the source and of the
openings.  A seed makes the cases; `--seed random` draws another one and prints it.

The rules' own errors are rows of their own, from a second rule, and stay below half of the bound.
Bounds are the tolerance asked for and the rounding of the phases and exponents that are added up.
"""

import sys
from typing import Any

import numpy as np
import surfaces_gratings
import surfaces_rough
import surfaces_slits
from common import Report
from evaluate import Case, Program, check

CHECKS = [
    surfaces_rough.lobes,
    surfaces_rough.facets,
    surfaces_rough.energy,
    surfaces_gratings.orders,
    surfaces_gratings.asymmetric_lobes,
    surfaces_slits.transfers,
]
HANDED = np.diag([1.0, 1.0, 1.0, -1.0])


def _of(op: str, change: Any) -> Any:  # noqa: ANN401
    """Return a falsification of the results of one operation."""

    def tamper(case: Case, result: dict[str, Any]) -> dict[str, Any]:
        return {**result, **change(case[1], result)} if case[0] == op else result

    tamper.__name__ = f"{op}: {change.__name__}"
    return tamper


def other_handedness(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take the other sign of S3 for light that goes out."""
    return {"M": (HANDED @ np.array(result["M"])).tolist()}


def turned_the_other_way(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take the other sense of rotation of frames."""
    mirror = np.diag([1.0, 1.0, -1.0, -1.0])
    return {"M": (mirror @ np.array(result["M"]) @ mirror).tolist()}


def transposed(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Mix up incident and outgoing light."""
    return {"M": np.swapaxes(np.array(result["M"]), -1, -2).tolist()}


def without_obliquity(inputs: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Leave out the obliquity factor of heights."""
    i, o = inputs["to_source"], inputs["to_observer"]
    phi = np.array([*result["phi_t"], result["phi_z"]])
    factor = abs(i @ phi * (o @ phi) / (i[2] * o[2] * phi[2] ** 2))
    return {"M": (np.array(result["M"]) / factor).tolist()}


def slightly_bright(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Send out a thousandth more than came."""
    return {"M": (1.001 * np.array(result["M"])).tolist()}


def without_the_mirror(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Forget what leaves sharply."""
    return {"beams": []}


def two_pi_off(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Use another convention of the Fourier transform."""
    return {"value": result["value"] / (2 * np.pi)}


def always_coherent(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Forget that roughness dims the mirror."""
    return {"coherent_weight": 1.0}


def mirrored_orders(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Count orders the other way."""
    return {"orders": [[-q for q in order] for order in result["orders"]]}


def conjugated_amplitudes(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take the other sign of a height's phase."""
    return {"amplitude": np.conj(result["amplitude"]).tolist()}


def one_phase_for_all(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take the mean φ_z for that of each order."""
    return {"phi_z": [float(np.mean(result["phi_z"]))] * len(result["phi_z"])}


def not_capped(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Give out what the phase says."""
    return {"efficiency": result["share"]}


def merely_capped(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take efficiencies that lose light for those that do not."""
    return {"lossless": result["efficiency"]} if "lossless" in result else {}


def full_visibility(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Forget the openings."""
    return {"visibility": [abs(result["gamma"])] * len(result["visibility"])}


def squared_coherence(_: dict[str, Any], result: dict[str, Any]) -> dict[str, Any]:
    """Take |γ|² for γ."""
    return {"gamma": abs(result["gamma"]) ** 2}


FALSIFIED = [
    *(_of("lobe", change) for change in (two_pi_off, always_coherent)),
    *(
        _of("surface", change)
        for change in (
            other_handedness,
            turned_the_other_way,
            transposed,
            without_obliquity,
            slightly_bright,
            without_the_mirror,
        )
    ),
    *(
        _of("grating", change)
        for change in (
            mirrored_orders,
            conjugated_amplitudes,
            one_phase_for_all,
            not_capped,
            merely_capped,
        )
    ),
    *(
        _of("slits", change)
        for change in (other_handedness, transposed, full_visibility, squared_coherence)
    ),
]


def compare(program: Program, seed: int) -> Report:
    """Run every check on the cases of one seed."""
    report = Report(f"Surfaces, gratings and slits, seed {seed} (largest error, relative)")
    for chapter in CHECKS:
        for what, error, bound in chapter(program, seed):
            report.within(what, float(error), float(bound))
    return report


if __name__ == "__main__":
    sys.exit(check(__doc__, compare, FALSIFIED, seed=1))
