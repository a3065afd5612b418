"""Fresnel's formulas and Mueller calculus in numpy, independent of Brewster's code.

Signs: time factor exp(+iωt), refractive index n = η − ik, first axis s (across the plane of
incidence), r_p = −r_s at normal incidence (Verdet).  Stokes vectors are seen against the
propagation, S3 > 0 turns clockwise for that observer, and angles run counter-clockwise for him.
A Mueller matrix is [...,4,4].
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Amplitudes = tuple[NDArray[np.complex128], NDArray[np.complex128]]


def cos_refracted(n1: ArrayLike, n2: ArrayLike, cos1: ArrayLike) -> NDArray[np.complex128]:
    """Return the complex cosine in medium 2, on the branch that decays into it."""
    n1, n2, cos1 = np.asarray(n1), np.asarray(n2, complex), np.asarray(cos1)
    # k_z / k0 in medium 2; exp(+iωt − ikz z) decays where Im k_z < 0
    kz = np.sqrt(n2**2 - n1**2 * (1 - cos1**2))
    return np.where(kz.imag > 0, -kz, kz) / n2


def reflection_amplitudes(n1: ArrayLike, n2: ArrayLike, cos1: ArrayLike) -> Amplitudes:
    """Return (r_s, r_p)."""
    n1, n2, cos1 = np.asarray(n1), np.asarray(n2, complex), np.asarray(cos1)
    cos2 = cos_refracted(n1, n2, cos1)
    r_s = (n1 * cos1 - n2 * cos2) / (n1 * cos1 + n2 * cos2)
    r_p = (n2 * cos1 - n1 * cos2) / (n2 * cos1 + n1 * cos2)
    return r_s, r_p


def transmission_amplitudes(n1: ArrayLike, n2: ArrayLike, cos1: ArrayLike) -> Amplitudes:
    """Return (t_s, t_p), scaled to power: squares include n2 cos2 / (n1 cos1)."""
    n1, n2, cos1 = np.asarray(n1), np.asarray(n2, complex), np.asarray(cos1)
    cos2 = cos_refracted(n1, n2, cos1)
    power = np.sqrt(np.maximum((n2 * cos2).real, 0) / (n1 * cos1))
    t_s = 2 * n1 * cos1 / (n1 * cos1 + n2 * cos2)
    t_p = 2 * n1 * cos1 / (n2 * cos1 + n1 * cos2)
    return power * t_s, power * t_p


def from_amplitudes(s: ArrayLike, p: ArrayLike) -> Array:
    """Return the Mueller matrix of the diagonal Jones matrix diag(s, p)."""
    s, p = np.asarray(s, complex), np.asarray(p, complex)
    m = np.zeros((*np.broadcast_shapes(s.shape, p.shape), 4, 4))
    m[..., 0, 0] = m[..., 1, 1] = (abs(s) ** 2 + abs(p) ** 2) / 2
    m[..., 0, 1] = m[..., 1, 0] = (abs(s) ** 2 - abs(p) ** 2) / 2
    cross = s * np.conj(p)
    m[..., 2, 2] = m[..., 3, 3] = cross.real
    m[..., 2, 3] = cross.imag
    m[..., 3, 2] = -cross.imag
    return m


def rotation(angle: ArrayLike) -> Array:
    """Return the matrix to a frame turned by `angle` counter-clockwise."""
    angle = np.asarray(angle)
    c, s = np.cos(2 * angle), np.sin(2 * angle)
    m = np.zeros((*angle.shape, 4, 4))
    m[..., 0, 0] = m[..., 3, 3] = 1
    m[..., 1, 1] = m[..., 2, 2] = c
    m[..., 1, 2], m[..., 2, 1] = s, -s
    return m


def at_angle(m: Array, angle: ArrayLike) -> Array:
    """Return the element `m` with its first axis at `angle`."""
    return rotation(-np.asarray(angle)) @ m @ rotation(angle)


def polarizer() -> Array:
    """Return the ideal polarizer that passes E along the first axis."""
    return from_amplitudes(1, 0)


def retarder(delta: ArrayLike) -> Array:
    """Return the retarder by `delta` whose fast axis is the first axis."""
    return from_amplitudes(np.exp(1j * np.asarray(delta)), 1)


def circular_polarizer(handedness: int) -> Array:
    """Return the filter that passes S3 = `handedness` × S0, with `handedness` ±1."""
    pass_state = np.array([1, 0, 0, handedness])
    return np.outer(pass_state, pass_state) / 2
