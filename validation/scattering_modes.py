"""The scattered modes and shape of Theorem S4.1 from the light that they are to be the modes of."""

from functools import cache
from typing import Any

import numpy as np
from common import Array
from evaluate import Case, Program
from hermite_gauss import hermite_table
from light_grids import EPS, STEP, Rows, grid, largest, moved
from scattering_matter import encounter

ENVELOPES = ("gaussian", "gaussian_mixture", "rect", "disk")
# h_6 ends at 9; the transforms of the envelopes have frequencies below 3.5 per whitened unit
EXTENT, STEPS = 9.6, 0.4
# steps of the differences, in whitened units
STEP_LONG, STEP_SHORT = 0.08, 0.04
# tenth derivative of ln|C_0| along these lines: Σ 10!/(5 j^10) over the zeros j of 2J₁(z)/z at
# z = 2√2 y, for a disk; of sin(z)/z a tenth of it, and Gaussians have none
TENTH = 4e4
# weights of the central difference of the second derivative, error of the 8th order in the step
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])


def whitened(inputs: dict[str, Any], root: Array, y: Array) -> Array:
    """Return the separations ξ at the whitened points y = W (k/r) ξ."""
    k = 2 * np.pi / inputs["lambda"]
    return inputs["r"] / k * y @ np.linalg.inv(root).T


@cache
def cases(seed: int) -> list[dict[str, Any]]:
    """Return one encounter for each kind of envelope."""
    rng = np.random.default_rng([seed, 5])
    return [encounter(rng, envelope)[0] for envelope in ENVELOPES]


def with_separations(inputs: dict[str, Any], xi: Array) -> Case:
    """Return the case of these inputs at other separations."""
    return ("interaction", {**inputs, "xi": xi})


def projections(program: Program, seed: int) -> Rows:
    """c^(l)_ab = r² ∫ C_l φ_ab(w; W) d²w, w = (k/r) ξ, C_l sampled on a grid."""
    y, weight = grid(EXTENT, STEPS)
    side = round(np.sqrt(len(y)))
    for inputs in cases(seed):
        [known] = program([("interaction", inputs)])
        root = np.array(known["W_out"])
        [found] = program([with_separations(inputs, whitened(inputs, root, y))])
        h = hermite_table(inputs["N_out"], y[:side, 1])
        jacobian = weight * inputs["r"] ** 2 / np.sqrt(abs(np.linalg.det(root)))
        samples = np.array(found["C_samples"])
        scale = jacobian * np.abs(samples).sum() * h.max() ** 2
        error = 0.0
        for parameter in range(4):
            c = jacobian * h @ samples[:, parameter].reshape(side, side) @ h.T
            rows = known["c_white"][parameter]
            error = largest(
                error, (abs(rows[n][b] - c[n - b, b]) for n in range(7) for b in range(n + 1))
            )
        name = f"⟨C_l|φ_ab⟩, N = {inputs['N_out']}, {inputs['I']['kind']}"
        yield name, error / scale, moved(y, inputs["N_out"]) * np.linalg.cond(root)


def hessian(program: Program, inputs: dict[str, Any], root: Array, step: float) -> Array:
    """Return the second derivatives of ln|C_0| by y, from central differences along three lines."""
    lines = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    offsets = np.arange(-4, 5) * step
    y = (offsets[None, :, None] * lines[:, None, :]).reshape(-1, 2)
    [found] = program([with_separations(inputs, whitened(inputs, root, y))])
    logs = np.log(np.abs(np.array(found["C_samples"])[:, 0])).reshape(3, 9)
    along_x, along_y, along_both = logs @ SECOND / step**2
    across = 0.5 * (along_both - along_x - along_y)
    return np.array([[along_x, across], [across, along_y]])


def shapes(program: Program, seed: int) -> Rows:
    """Θ⁻¹ = −Hess ln|C_0| at 0."""
    for inputs in cases(seed):
        [known] = program([("interaction", inputs)])
        root = np.array(known["W_out"])
        near, nearer = (hessian(program, inputs, root, h) for h in (STEP_LONG, STEP_SHORT))
        theta = np.array(known["Theta_out"])
        # W Θ W' = 1 where the shape is right, whichever root W it has
        found = root @ theta @ root.T
        kind = inputs["I"]["kind"]
        # rounding: the weights' moduli add up to 7, |ln C| moves by ε; the rule leaves h⁸/3150 of
        # the tenth derivative
        bound = 4 * STEP * EPS * 7 / STEP_SHORT**2 + STEP_SHORT**8 / 3150 * TENTH
        yield f"Θ⁻¹ = −Hess ln|C_0|, {kind}", abs(-nearer @ found - np.eye(2)).max(), bound
        yield "  between two steps", abs(near - nearer).max(), bound + STEP_LONG**8 / 3150 * TENTH
