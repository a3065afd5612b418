"""Interfaces, films and plates against colour-science and tmm."""

from typing import Any

import numpy as np
import tmm
from colour import phenomena
from evaluate import Case, Program
from fields_shared import EPS, RANDOM, ROUNDINGS, Numbers, Rows, row, with_bound

# relative to ε: π/180 and nm of the programs that want degrees and nm
UNITS = 4.0


def amplitudes(result: dict[str, Any]) -> list[complex]:
    """Return r_s, r_p, t_s, t_p."""
    return [result[key] for key in ("r_s", "r_p", "t_s", "t_p")]


def powers(result: dict[str, Any]) -> list[float]:
    """Return R and T of s and of p."""
    return [*result["R"], *result["T"]]


# ------------------------------------------------------------ interfaces


def interfaces_by_colour(program: Program) -> Rows:
    """Snell's law, Fresnel amplitudes and coefficients, below the critical angle."""
    drawn = RANDOM.uniform([1, 1, 0], [3, 3, 1.5], (400, 3))
    drawn = drawn[drawn[:, 0] * np.sin(drawn[:, 2]) < 0.999 * drawn[:, 1]]

    def other(inputs: Numbers) -> Numbers:
        n1, n2, theta_i = *inputs[:2], np.degrees(inputs[2])
        theta_t = phenomena.snell_law(n1, n2, theta_i)
        r = phenomena.polarised_light_reflection_amplitude(n1, n2, theta_i, theta_t)
        t = phenomena.polarised_light_transmission_amplitude(n1, n2, theta_i, theta_t)
        cos_t = np.cos(np.radians(theta_t))
        return np.real([r[0], -r[1], t[0], t[1], cos_t])

    def coefficients(inputs: Numbers) -> Numbers:
        n1, n2, theta_i = *inputs[:2], np.degrees(inputs[2])
        theta_t = phenomena.snell_law(n1, n2, theta_i)
        reflected = phenomena.polarised_light_reflection_coefficient(n1, n2, theta_i, theta_t)
        passed = phenomena.polarised_light_transmission_coefficient(n1, n2, theta_i, theta_t)
        return np.real([*reflected, *passed])

    cases: list[Case] = []
    for n1, n2, theta in drawn:
        cos_i = np.cos(theta)
        cases.append(("fresnel", {"n1": n1, "n2": n2, "cos_i": cos_i}))
        bare = {"n_incident": n1, "layers": [], "n_exit": n2, "cos_i": cos_i, "lambda": 5e-7}
        cases.append(("multilayer", bare))
    found = program(cases)
    expected, bound = zip(*[with_bound(other, inputs, UNITS) for inputs in drawn], strict=True)
    ours = np.array([amplitudes(result) for result in found[::2]])
    # Snell's law by the power weight n2 cos θ2/(n1 cos θ1)
    n1, n2, theta = drawn.T
    weight = [r["T"][0] / abs(r["t_s"]) ** 2 for r in found[1::2]]
    cos_t = (weight * n1 * np.cos(theta) / n2)[:, None]
    what = "interfaces, Snell and amplitudes (colour)"
    yield row(what, np.hstack([ours, cos_t]), expected, bound)
    expected, bound = zip(
        *[with_bound(coefficients, inputs, UNITS) for inputs in drawn], strict=True
    )
    what = "interfaces, power coefficients (colour)"
    yield row(what, [powers(r) for r in found[1::2]], expected, bound)


def index(kind: str) -> complex:
    """Return a random refractive index η − ik: of glass, or of matter that absorbs."""
    if kind == "glass":
        return complex(RANDOM.uniform(1, 3))
    return complex(RANDOM.uniform(0.05, 4), -(10 ** RANDOM.uniform(-4, 0.8)))


def by_tmm(inputs: Numbers) -> Numbers:
    """Return r_s, r_p, t_s, t_p, R and T of n0, …, nN, thicknesses over λ, angle."""
    media = len(inputs) // 2
    n = np.conj(inputs[: media + 1])
    thickness = [np.inf, *np.real(inputs[media + 1 : -1]), np.inf]
    theta = float(np.real(inputs[-1]))
    s, p = (tmm.coh_tmm(pol, n, thickness, theta, 1.0) for pol in "sp")
    r_t = [s["r"], p["r"], s["t"], p["t"]]
    return np.array([*np.conj(r_t), s["R"], p["R"], s["T"], p["T"]])


def stack(n: list[complex], thickness: list[float], theta: float) -> tuple[Numbers, Case]:
    """Return a stack as `by_tmm` wants it and as the program does; lengths over λ."""
    inputs = {
        "n_incident": n[0].real,
        "layers": [[index, d] for index, d in zip(n[1:-1], thickness, strict=True)],
        "n_exit": n[-1],
        "cos_i": np.cos(theta),
        "lambda": 1.0,
    }
    return np.array([*n, *thickness, theta], complex), ("multilayer", inputs)


def judged_by_tmm(program: Program, what: str, stacks: list[tuple[Numbers, Case]]) -> Rows:
    """Compare amplitudes and powers."""
    found = program([case for _, case in stacks])
    ours = [[*amplitudes(result), *powers(result)] for result in found]
    expected, bound = zip(*[with_bound(by_tmm, inputs) for inputs, _ in stacks], strict=True)
    yield row(f"{what} (tmm)", ours, expected, bound)


def angle(kind: str, n: list[complex]) -> float:
    """Return an angle of incidence: any, or one beyond a critical angle of the stack."""
    if kind != "total reflection":
        return RANDOM.uniform(0, 1.55)
    critical = np.arcsin(n[-1].real / n[0].real)
    return RANDOM.uniform(critical + 1e-2, 1.55)


def random_stack(kind: str, layers: int) -> tuple[Numbers, Case]:
    """Return a stack of `kind`: glass, absorbing, absorbing exit, or total reflection."""
    inner = "absorbing" if kind in ("absorbing", "absorbing exit") else "glass"
    n = [index("glass"), *(index(inner) for _ in range(layers)), index("glass")]
    if kind == "absorbing exit":
        n[-1] = index("absorbing")
    if kind == "total reflection":
        n[0], n[-1] = complex(RANDOM.uniform(1.6, 3)), complex(RANDOM.uniform(1, 1.5))
    # up to e^-20 in a layer: tmm caps what absorbs more than e^-35
    thickest = [min(1.5, 3 / (1e-9 - m.imag)) for m in n[1:-1]]
    return stack(n, [RANDOM.uniform(0.01, d) for d in thickest], angle(kind, n))


def interfaces_by_tmm(program: Program) -> Rows:
    """Single interfaces, absorbing ones and total reflection."""
    for kind in ("glass", "absorbing exit", "total reflection"):
        stacks = [random_stack(kind, 0) for _ in range(100)]
        yield from judged_by_tmm(program, f"interfaces, {kind}", stacks)
    # the same numbers by the operation for one interface
    pairs = [random_stack("absorbing exit", 0)[0] for _ in range(100)]
    cases: list[Case] = [
        ("fresnel", {"n1": n1, "n2": n2, "cos_i": np.cos(theta.real)}) for n1, n2, theta in pairs
    ]
    ours = [amplitudes(result) for result in program(cases)]
    expected, bound = zip(*[with_bound(by_tmm, inputs) for inputs in pairs], strict=True)
    what = "interfaces, amplitudes alone (tmm)"
    yield row(what, ours, np.array(expected)[:, :4], np.array(bound)[:, :4])


def films_by_tmm(program: Program) -> Rows:
    """Stacks of up to eight layers."""
    for kind in ("glass", "absorbing", "absorbing exit", "total reflection"):
        stacks = [random_stack(kind, RANDOM.integers(1, 9)) for _ in range(60)]
        yield from judged_by_tmm(program, f"films, {kind}", stacks)


# ------------------------------------------------------------ films


def films_by_colour(program: Program) -> Rows:
    """Reflectance and transmittance: real indices at any angle, others at normal incidence."""

    def other(inputs: Numbers) -> Numbers:
        media = len(inputs) // 2
        n = np.conj(inputs[: media + 1])
        theta = np.degrees(inputs[-1].real)
        if not n.imag.any():
            n = n.real
        t = inputs[media + 1 : -1].real * 500
        found = (
            phenomena.thin_film_tmm(n, t[0], 500, theta)
            if len(t) == 1
            else phenomena.multilayer_tmm(n, t, 500, theta)
        )
        return np.array(found).reshape(4)

    for kind in ("glass", "absorbing"):
        for layers in (1, 5):
            stacks: list[tuple[Numbers, Case]] = []
            while len(stacks) < 40:
                inputs, (op, case) = random_stack(kind, layers)
                if kind == "absorbing":
                    inputs[-1], case["cos_i"] = 0, 1.0
                largest = inputs[0].real * np.sin(inputs[-1].real)
                if largest < 0.99 * inputs[: len(inputs) // 2 + 1].real.min() or not inputs[-1]:
                    stacks.append((inputs, (op, case)))
            found = [powers(result) for result in program([case for _, case in stacks])]
            pairs = [with_bound(other, inputs, UNITS) for inputs, _ in stacks]
            expected, bound = zip(*pairs, strict=True)
            number = "thin film" if layers == 1 else "multilayer"
            yield row(f"{number}, {kind} (colour)", found, expected, bound)


# ------------------------------------------------------------ plates


def turn(alpha: float) -> Numbers:
    """Return the rotation by `alpha` from x to y."""
    return np.array([[np.cos(alpha), -np.sin(alpha)], [np.sin(alpha), np.cos(alpha)]])


def plate_bound(inputs: list[Numbers]) -> float:
    """Bound the rounding of a plate: 4 ε k₀ d |M| of phase with |M| ≤ 2(1 + |ε|), and tmm's."""
    phase = 0.0
    for numbers in inputs:
        media = len(numbers) // 2
        n, d = numbers[1:media], numbers[media + 1 : -1].real
        phase += float(np.sum(2 * np.pi * d * 8 * (1 + np.abs(n) ** 2)))
    others = max(float(with_bound(by_tmm, numbers)[1].max()) for numbers in inputs)
    return 2 * others + EPS * phase


def plates_by_tmm(program: Program) -> Rows:
    """Crystal plates where they are two films: optic axis along s, or normal incidence."""
    for kind in ("glass", "absorbing"):
        asked: list[Case] = []
        expected, bound = [], []
        for case in range(60):
            normal = case % 2 == 0
            first, (_, inputs) = random_stack(kind, 3)
            theta = 0.0 if normal else float(first[-1].real)
            media = len(first) // 2
            second = first.copy()
            second[1:media] += RANDOM.uniform(0.01, 0.3, media - 1)
            first[-1] = second[-1] = theta
            alpha = RANDOM.uniform(-3, 3)
            axis = [np.cos(alpha), np.sin(alpha), 0.0]
            layers = [
                # ordinary light is `first`, extraordinary `second`
                {"n": [o, e], "axis": axis, "thickness": d}
                for o, e, (_, d) in zip(
                    first[1:media], second[1:media], inputs["layers"], strict=True
                )
            ]
            azimuth = 0.0 if normal else alpha
            inputs = {**inputs, "layers": layers, "cos_i": np.cos(theta), "azimuth": azimuth}
            asked.append(("plate", inputs))
            o, e = by_tmm(first), by_tmm(second)
            # in the frame of the axes: s-light is extraordinary, p-light ordinary
            r, t = np.diag([e[0], o[1]]), np.diag([e[2], o[3]])
            if normal:
                # p = z × s is the other way round in reflected light
                mirror = np.diag([1.0, -1.0])
                r = mirror @ turn(alpha) @ mirror @ r @ turn(-alpha)
                t = turn(alpha) @ t @ turn(-alpha)
            expected.append([r, t])
            bound.append(plate_bound([first, second]))
        found = [[result["r"], result["t"]] for result in program(asked)]
        limit = np.array(bound)[:, None, None, None]
        yield row(f"uniaxial plates, {kind} (tmm)", found, expected, limit)


def windows_by_tmm(program: Program) -> Rows:
    """Thick plates, powers added: R and T, from the front."""
    asked: list[Case] = []
    expected, bound = [], []
    for _ in range(60):
        _, (_, inputs) = random_stack("glass", 3)
        n = np.array([index("glass"), *(index("absorbing") for _ in range(3)), index("glass")])
        n[1:-1] = n[1:-1].real + 1 - 1e-6j
        thickness = RANDOM.uniform(1e2, 1e4, 3)
        # below all critical angles
        theta = RANDOM.uniform(0, 0.9) * np.arcsin(min(1.0, n.real.min() / n[0].real))
        layers = [{"n": m, "thickness": d} for m, d in zip(n[1:-1], thickness, strict=True)]
        own = {"n_incident": n[0].real, "n_exit": n[-1], "cos_i": np.cos(theta)}
        inputs = {**inputs, **own, "layers": layers, "method": "incoherent"}
        asked.append(("plate", inputs))
        d_list = [np.inf, *thickness, np.inf]
        s, p = (tmm.inc_tmm(pol, np.conj(n), d_list, ["i"] * 5, theta, 1.0) for pol in "sp")
        expected.append([s["R"], p["R"], s["T"], p["T"]])
        # no phases: an ulp of the absorbed share at most, and a few of the faces
        bound.append(ROUNDINGS * EPS * (4 + float(np.sum(4 * np.pi * 1e-6 * thickness))))
    found = [powers(result) for result in program(asked)]
    yield row("thick windows, incoherent (tmm)", found, expected, np.array(bound)[:, None])
