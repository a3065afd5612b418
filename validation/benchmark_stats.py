"""Errors of Stokes images against a reference, and what they cost: the statistics of the benchmark.

An image A has the mean square error E = ⟨(A − R)² − Var R⟩ over pixels against a reference R that
is independent of it: the reference's own noise is taken off.  Images of several seeds also give it
without any reference, as the scatter between them; that one does not see bias.
"""

from dataclasses import dataclass

import numpy as np
from common import ROUND_OFF, Array

# the error that costs are extrapolated to, over mean S0
TARGET = 0.01
COMPONENTS = 4


@dataclass
class Reference:
    """A long rendering: mean and variance of it, both [H,W,4], and where it is from."""

    mean: Array
    variance: Array
    origin: str

    def level(self) -> float:
        """Return mean S0, what errors are relative to."""
        return float(self.mean[:, :, 0].mean())

    def noise(self) -> Array:
        """Return the mean variance of each component."""
        return self.variance.mean((0, 1))


def mean_square(image: Array, reference: Reference) -> Array:
    """Return the mean square error of each component, the reference's noise taken off."""
    return ((image - reference.mean) ** 2 - reference.variance).mean((0, 1))


def scatter(images: list[Array]) -> Array:
    """Return the mean variance of each component between images."""
    return np.var(np.stack(images), axis=0, ddof=1).mean((0, 1))


def seconds(cpu: float, square: float, level: float) -> float:
    """Return the CPU seconds to `TARGET`: those spent × (error/target)²; NaN for no error."""
    return cpu * square / (TARGET * level) ** 2 if square > 0 else float("nan")


def vanishes(square: float, level: float) -> bool:
    """Return whether nothing but rounding is left of an error or of a component."""
    return square <= (ROUND_OFF * level) ** 2


def geometric_mean(ratios: list[float]) -> float:
    """Return the geometric mean, NaN of nothing."""
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else float("nan")
