"""What `stability.py` asks and what it allows: a case, the true numbers, and their rounding."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from evaluate import Case
from hermite_gauss import Table
from light_grids import turn
from mpmath import mp

# distance of 1 to the next number
EPS = {"f64": 2.0**-52, "f32": 2.0**-23}
# where numbers of the type lose digits; a denormal is off by half of the second
LEAST = {"f64": (2.0**-1022, 2.0**-1074), "f32": (2.0**-126, 2.0**-149)}
Path = tuple[Any, ...]
Vary = Callable[[list[Any]], Table]


@dataclass
class Expected:
    """A true number, the size of what its computation adds up, and what an ulp of input does.

    The error may be `allowed` · ε · `scale`.
    """

    value: Any
    scale: Any
    sensitivity: Any
    allowed: float

    def units(self, found: Any, kind: str) -> tuple[float, float]:  # noqa: ANN401
        """Return the error in ε max(scale, |value| + sensitivity) and over what is allowed."""
        if found is None or not np.isfinite(found):
            return np.inf, np.inf
        error = abs(mp.mpmathify(found) - self.value)
        # gradual underflow at the end of every computation, on both factors of a product
        floor = 4 * LEAST[kind][1]
        least = EPS[kind] * max(self.scale, abs(self.value) + self.sensitivity)
        limit = self.allowed * EPS[kind] * self.scale
        return float(error / (least + floor)), float(error / (limit + floor))


def from_inputs(value: Any, sensitivity: Any, order: int) -> Expected:  # noqa: ANN401
    """Return the expectation that no more is lost than `rounding` and rounded inputs cost."""
    return Expected(value, abs(value) + sensitivity, sensitivity, rounding(order))


@dataclass
class Question:
    """One case of one region, with what is expected at which place of the result."""

    region: str
    case: Case
    expected: dict[Path, Expected] = field(default_factory=dict)
    kind: str = "f64"


def at(result: Any, path: Path) -> Any:  # noqa: ANN401
    """Return the number at `path` of a result, None where there is none."""
    for step in path:
        try:
            result = result[step]
        except (KeyError, IndexError, TypeError):
            return None
    return result


def root(rng: np.random.Generator, condition: float, size: float) -> np.ndarray:
    """Return a random root W of the given cond Θ and geometric mean of singular values."""
    long = size * condition**0.25
    left, right = rng.uniform(-np.pi, np.pi, 2)
    return turn(left) @ np.diag([long, size**2 / long]) @ turn(right)


def shape(rng: np.random.Generator, condition: float, size: float) -> np.ndarray:
    """Return a random Θ of the given condition number and geometric mean of eigenvalues."""
    long = size * condition**0.5
    axis = turn(rng.uniform(-np.pi, np.pi))
    theta = axis @ np.diag([long, size**2 / long]) @ axis.T
    theta[1, 0] = theta[0, 1]
    return theta


def varied(function: Vary, inputs: list[Any]) -> tuple[Table, Table]:
    """Return `function(inputs)` and Σ|x_i ∂f/∂x_i| over its inputs: what an ulp of each does."""
    step = mp.mpf(10) ** (-mp.dps // 3)
    here = function(inputs)
    change = dict.fromkeys(here, mp.mpf(0))
    for i, value in enumerate(inputs):
        if value:
            there = function([*inputs[:i], value * (1 + step), *inputs[i + 1 :]])
            for place, number in here.items():
                change[place] += abs(there[place] - number) / step
    return here, change


def rounding(order: int) -> float:
    """Return how many ε a recurrence of so many steps may lose of its envelope.

    A step of h_n rounds three products, two factors and a sum: at most 4.5 ε of the envelope
    max(|h_n|, |h_{n−1}|).  Errors of different steps have different signs and add up like a
    random walk, 3.5 standard deviations of which are 16 √(n + 1).
    """
    return 16 * float(np.sqrt(order + 1))
