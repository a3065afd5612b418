"""The perspective camera of the scenes in numpy: rays through a pixel grid and their frames."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def unit(v: Array) -> Array:
    """Normalize along the last axis."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def dot(a: Array, b: Array) -> Array:
    """Return the scalar product along the last axis."""
    return np.sum(a * b, -1)


@dataclass
class Rays:
    """Rays [H,W,K] with K samples a pixel, and the Stokes frame at the sensor.

    `e_x` points right in the image and `e_y` up; light travels along −direction.
    """

    origin: Array
    direction: Array
    e_x: Array
    e_y: Array

    def angle_of(self, axis: Array) -> Array:
        """Return the angle of `axis` from e_x, counter-clockwise for the sensor."""
        return np.arctan2(dot(axis, self.e_y), dot(axis, self.e_x))


def look_at(
    origin: tuple[float, ...],
    target: tuple[float, ...],
    fov_x: float,
    size: tuple[int, int],
    samples: int,
) -> Rays:
    """Return samples² rays a pixel, in the middle of equal cells; up is +y, row 0 on top.

    `fov_x` is the horizontal field of view in degrees, `size` is (width, height).
    """
    width, height = size
    forward = unit(np.subtract(target, origin).astype(float))
    right = unit(np.cross(forward, [0.0, 1.0, 0.0]))
    up = np.cross(right, forward)
    grid = (np.arange(samples) + 0.5) / samples
    x = (np.arange(width)[:, None] + grid) / width * 2 - 1
    y = 1 - (np.arange(height)[:, None] + grid) / height * 2
    y = y * height / width
    # [H, W, samples, samples]
    x, y = np.broadcast_arrays(x[None, :, None, :], y[:, None, :, None])
    half = np.tan(np.radians(fov_x) / 2)
    d = forward + half * (x[..., None] * right + y[..., None] * up)
    d = unit(d.reshape(height, width, samples**2, 3))
    e_x = unit(np.cross(d, up))
    return Rays(np.asarray(origin, float), d, e_x, np.cross(-d, e_x))
