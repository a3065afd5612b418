"""What the chapters of `fields.py` share: rows of the table, bounds, falsified answers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from evaluate import Case
from numpy.typing import ArrayLike, NDArray

EPS = 2.0**-52
# roundings allowed on both sides together
ROUNDINGS = 64
# what the other programs said, so that a self-test need not ask again
KNOWN: dict[tuple[str, bytes, float], tuple[Any, Any]] = {}
# step of the differences that say what an ulp of an input does
STEP = 1e-7

RANDOM = np.random.default_rng(1996)
AT_THE_START = RANDOM.bit_generator.state

Numbers = NDArray[np.float64] | NDArray[np.complex128]


@dataclass
class Row:
    """A line of the table: the largest difference as it is, and in units of its bound."""

    what: str
    cases: int
    largest: float
    share: float


Rows = Iterator[Row]


def same_numbers_again() -> None:
    """Draw the same inputs as the first time, so that answers from memory fit."""
    RANDOM.bit_generator.state = AT_THE_START


def row(what: str, found: ArrayLike, expected: ArrayLike, bound: ArrayLike) -> Row:
    """Compare arrays whose first axis counts the cases."""
    difference = np.abs(np.asarray(found) - np.asarray(expected))
    share = difference / np.asarray(bound)
    return Row(what, len(difference), float(difference.max()), float(share.max()))


def with_bound(
    function: Callable[[Numbers], Numbers], inputs: Numbers, extra: float = 0.0
) -> tuple[Numbers, NDArray[np.float64]]:
    """Return `function(inputs)` and the bound: what an ulp of each input does to it, added up.

    `extra` is the share of ε by which the other program's own inputs are rounded beforehand.
    """
    key = (function.__qualname__, inputs.tobytes(), extra)
    if key not in KNOWN:
        KNOWN[key] = _with_bound(function, inputs, extra)
    return KNOWN[key]


def _with_bound(
    function: Callable[[Numbers], Numbers], inputs: Numbers, extra: float
) -> tuple[Numbers, NDArray[np.float64]]:
    value = function(inputs)
    moved = np.zeros(value.shape)
    for i, number in enumerate(inputs):
        for way in (1, 1j) if np.imag(number) else (1,):
            ahead, behind = inputs.copy(), inputs.copy()
            ahead[i] += STEP * way * abs(number)
            behind[i] -= STEP * way * abs(number)
            moved += np.abs(function(ahead) - function(behind)) / (2 * STEP)
    return value, ROUNDINGS * EPS * (1 + extra) * (np.abs(value) + moved + 1)


# ------------------------------------------------------------ falsified answers


def changed(value: Any, change: Callable[[Any], Any]) -> Any:  # noqa: ANN401
    """Return `value` with every number changed."""
    if isinstance(value, list):
        return [changed(entry, change) for entry in value]
    if isinstance(value, dict):
        return {key: changed(entry, change) for key, entry in value.items()}
    return change(value)


def conjugated(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Use the other time factor."""
    return changed(result, np.conj)


def p_turned(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Give r_p the other sign."""
    return {key: changed(v, np.negative) if key == "r_p" else v for key, v in result.items()}


def other_hand(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Give S3 the other sign, behind the element only."""
    return {
        key: [*value[:3], changed(value[3], np.negative)] if key == "M" else value
        for key, value in result.items()
    }


def s_and_p_swapped(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Mistake s for p in powers."""
    return {key: value[::-1] if key in ("R", "T") else value for key, value in result.items()}


def without_power_weight(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Take the squared amplitude for the transmitted power."""
    if "t_s" not in result:
        return result
    return {**result, "T": [abs(result["t_s"]) ** 2, abs(result["t_p"]) ** 2]}


def factors_swapped(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Decompose with the depolarizer first."""
    if "depolarizer" not in result:
        return result
    depolarizer = np.array(result["depolarizer"]).T.tolist()
    return {**result, "depolarizer": depolarizer, "retarder": result["diattenuator"]}


def eigenvalues_doubled(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Normalize the coherency matrix as a tensor of moments."""
    return {k: changed(v, lambda x: 2 * x) if k == "eigenvalues" else v for k, v in result.items()}


def fields_not_powers(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Take a diattenuation of amplitudes."""
    if "singular_values" not in result:
        return result
    best, worst = result["singular_values"]
    return {**result, "diattenuation": (best - worst) / (best + worst)}


def seventh_digit_lost(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Move the light of Gaussian Schell-model beams by one unit of the last printed digit."""
    if "stokes" not in result:
        return result
    s0, s1, *rest = result["stokes"]
    return {**result, "stokes": [s0, s1 + 1e-6 * s0, *rest]}


def eleven_digits(_: Case, result: dict[str, Any]) -> dict[str, Any]:
    """Keep eleven digits."""
    return changed(result, lambda x: x * (1 + 1e-11))


FALSIFIED = [
    conjugated,
    p_turned,
    other_hand,
    s_and_p_swapped,
    without_power_weight,
    factors_swapped,
    eigenvalues_doubled,
    fields_not_powers,
    seventh_digit_lost,
    eleven_digits,
]
