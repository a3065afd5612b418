"""Elements, Mueller matrices and decompositions against py_pol; beams against a table."""

from typing import Any

import numpy as np
from evaluate import Case, Program
from fields_shared import EPS, RANDOM, ROUNDINGS, Numbers, Rows, row
from py_pol.jones_matrix import Jones_matrix
from py_pol.mueller import Mueller

CASES = 200
# a few functions of angles on both sides
ELEMENT = ROUNDINGS * EPS


def first_axis_last(matrices: Numbers) -> Numbers:
    """Count the cases by the last axis, as py_pol does, or back by the first one."""
    return np.moveaxis(np.asarray(matrices), 0, -1)


def cases_first(matrices: Numbers) -> Numbers:
    """Count the cases by the first axis."""
    return np.moveaxis(np.asarray(matrices), -1, 0)


def elements(program: Program) -> Rows:
    """Jones matrices of named elements, all of them turned."""
    azimuth, turned = RANDOM.uniform(0, np.pi, (2, CASES))
    chi = RANDOM.uniform(-np.pi / 4, np.pi / 4, CASES)
    delay = RANDOM.uniform(0, np.pi, CASES)
    p1, p2 = RANDOM.uniform(0, 1, (2, CASES))
    ellipse = {"azimuth": azimuth, "ellipticity": chi}
    pairs: list[tuple[str, dict[str, Any], str, dict[str, Any]]] = [
        ("linear_polarizer", {}, "diattenuator_perfect", {"azimuth": 0 * azimuth}),
        ("partial_polarizer", {"x": p1, "y": p2}, "diattenuator_linear", {"p1": p1, "p2": p2}),
        ("linear_retarder", {"retardance": delay}, "retarder_linear", {"R": delay}),
        ("quarter_wave_plate", {}, "quarter_waveplate", {"azimuth": 0 * azimuth}),
        ("half_wave_plate", {}, "half_waveplate", {"azimuth": 0 * azimuth}),
        (
            "elliptical_retarder",
            {**ellipse, "retardance": delay},
            "retarder_azimuth_ellipticity",
            {**ellipse, "R": delay},
        ),
        (
            "circular_retarder",
            {"retardance": delay},
            "retarder_azimuth_ellipticity",
            {"azimuth": 0 * azimuth, "ellipticity": 0 * chi + np.pi / 4, "R": delay},
        ),
        (
            "elliptical_polarizer",
            ellipse,
            "diattenuator_azimuth_ellipticity",
            {**ellipse, "p1": 0 * p1 + 1, "p2": 0 * p2},
        ),
        (
            "homogeneous",
            {**ellipse, "first": p1, "second": p2 * np.exp(-1j * delay)},
            "diattenuator_retarder_azimuth_ellipticity",
            {**ellipse, "p1": p1, "p2": p2, "R": delay},
        ),
    ]
    for name, ours, its, theirs in pairs:
        asked: list[Case] = [
            (
                "jones_element",
                {"element": name, "rotated": turned[i]} | {k: v[i] for k, v in ours.items()},
            )
            for i in range(CASES)
        ]
        results = program(asked)
        element = Jones_matrix("element")
        getattr(element, its)(**theirs, length=CASES)
        element.rotate(turned)
        mueller = Mueller("element")
        mueller.from_Jones(element)
        expected = cases_first(element.M)
        found = np.array([result["T"] for result in results])
        # py_pol leaves out phases common to both axes
        overlap = np.einsum("nij,nij->n", expected.conj(), found)
        found = found * (overlap.conj() / np.abs(overlap))[:, None, None]
        name = name.replace("_", " ")
        yield row(f"{name}, Jones (py_pol)", found, expected, ELEMENT)
        found = np.array([result["M"] for result in results])
        yield row(f"{name}, Mueller (py_pol)", found, cases_first(mueller.M), ELEMENT)


def random_jones() -> Numbers:
    """Return random Jones matrices, some of them nearly singular."""
    parts = RANDOM.normal(size=(2, CASES, 2, 2))
    jones = parts[0] + 1j * parts[1]
    jones[::4, 1] = jones[::4, 0] + 1e-3 * jones[::4, 1]
    return jones


def mueller_matrices(program: Program) -> Rows:
    """Mueller matrices of random Jones matrices."""
    jones = random_jones()
    found = [result["M"] for result in program([("jones", {"T1": t}) for t in jones])]
    element, mueller = Jones_matrix("element"), Mueller("element")
    element.from_matrix(first_axis_last(jones))
    mueller.from_Jones(element)
    bound = ELEMENT * np.sum(np.abs(jones) ** 2, (1, 2))[:, None, None]
    yield row("Mueller of Jones (py_pol)", found, cases_first(mueller.M), bound)


def jones_parameters(program: Program) -> Rows:
    """Diattenuation of random Jones matrices, and retardance of retarders."""
    jones = random_jones()
    asked: list[Case] = [("jones_element", {"element": "matrix", "T": t}) for t in jones]
    element, mueller = Jones_matrix("element"), Mueller("element")
    element.from_matrix(first_axis_last(jones))
    mueller.from_Jones(element)
    found = [result["diattenuation"] for result in program(asked)]
    yield row("diattenuation (py_pol)", found, mueller.parameters.diattenuation(), ELEMENT)
    delay = RANDOM.uniform(0.01, 3.13, CASES)
    azimuth, chi = RANDOM.uniform(0, np.pi, CASES), RANDOM.uniform(-0.78, 0.78, CASES)
    element.retarder_azimuth_ellipticity(R=delay, azimuth=azimuth, ellipticity=chi)
    matrices = cases_first(element.M)
    asked = [("jones_element", {"element": "matrix", "T": t}) for t in matrices]
    found = [result["retardance"] for result in program(asked)]
    yield row("retardance (py_pol)", found, element.parameters.retardance(), 2 * ELEMENT)


def mueller_of(jones: Numbers) -> Numbers:
    """Return ½ tr(σ_l T σ_j T†) of each matrix."""
    sigma = np.array([[[1, 0], [0, 1]], [[1, 0], [0, -1]], [[0, 1], [1, 0]], [[0, -1j], [1j, 0]]])
    return np.einsum("lba,nap,jpq,nbq->nlj", sigma, jones, sigma, jones.conj()).real / 2


def decompositions(program: Program) -> Rows:
    """Lu-Chipman factors and Cloude eigenvalues of mixtures of five Jones matrices."""
    mixtures = sum(
        RANDOM.uniform(0, 1) * mueller_of(RANDOM.permutation(random_jones())) for _ in range(5)
    )
    mixtures = mixtures / (1.5 * mixtures[:, :1, :1])
    results = program([("decompose", {"M": m}) for m in mixtures])
    matter = Mueller("matter")
    matter.from_matrix(first_axis_last(mixtures))
    covariance = cases_first(matter.covariance_matrix().M)
    expected = np.linalg.eigvalsh(covariance)
    found = [result["eigenvalues"] for result in results]
    yield row("Cloude eigenvalues (py_pol)", found, expected, ELEMENT)
    found = [r["eigenvalues"] for r in program([("coherency", {"M": m}) for m in mixtures])]
    yield row("coherency eigenvalues (py_pol)", found, expected, ELEMENT)
    matter.from_matrix(first_axis_last(mixtures))
    purity = np.sqrt(1 - matter.parameters.depolarization_index() ** 2)
    found = [result["depolarization_index"] for result in results]
    yield row("depolarization index (py_pol)", found, purity, 2 * ELEMENT / purity)
    # three positive factors make the retarder unique; py_pol takes those below 1e-6 for zero
    blocks = [np.array(result["depolarizer"])[1:, 1:] for result in results]
    regular = np.array([np.linalg.eigvalsh(block)[0] > 1e-4 for block in blocks])
    matter.from_matrix(first_axis_last(mixtures))
    factors = [cases_first(f.M)[regular] for f in matter.analysis.decompose_polar("PRD")]
    kept = [result for result, good in zip(results, regular, strict=True) if good]
    m00 = mixtures[regular, 0, 0][:, None, None]
    d = np.linalg.norm(mixtures[regular, 0, 1:], axis=1)[:, None, None] / m00
    least = np.linalg.eigvalsh([b for b, good in zip(blocks, regular, strict=True) if good])
    bound = ELEMENT / (1 - d**2) / least[:, :1, None]
    scales = {"retarder": 1.0, "diattenuator": m00, "depolarizer": 1.0}
    for (key, scale), expected in zip(scales.items(), factors, strict=True):
        found = scale * np.array([result[key] for result in kept])
        yield row(f"Lu-Chipman, {key} (py_pol)", found, expected, bound)


# S1/S0 on the axis, λ = 632.8 nm, σ = 1 cm, δ = 0.2 and 0.4 mm (James 1994; Wolf 2007): by z in
# metres, for A_x = A_y and for A_y² = A_x²/2; with the digits that are printed
TABLE = [
    (
        1.0,
        {
            1.0: "-.000949416",
            10: "-.0820812",
            100: "-.5643040",
            1000: "-.5995258",
            1e9: "-.5999040",
        },
    ),
    (0.5, {0.0: ".3333333", 1.0: ".3324891", 10: ".2583198", 100: "-.2844821"}),
    (0.5, {1000.0: "-.3326748", 1e9: "-.3332000"}),
]


def schell_beams(program: Program) -> Rows:
    """Unpolarized sources that become polarized on the way, to all printed digits."""
    cases: list[Case] = []
    printed: list[str] = []
    for ratio, numbers in TABLE:
        source = {"lambda": 632.8e-9, "sigma": 1e-2, "dxx": 2e-4, "dyy": 4e-4, "dxy": 3.2e-4}
        source |= {"Ax": 1.0, "Ay": np.sqrt(ratio), "Bxy": 0.0, "rho": 0.0}
        cases += [("egsm", {**source, "z": z}) for z in numbers]
        printed += numbers.values()
    results = program(cases)
    found = [result["stokes"][1] / result["stokes"][0] for result in results]
    half = [0.5 * 10.0 ** -len(text.split(".")[1]) for text in printed]
    expected = [float(text) for text in printed]
    yield row("Gaussian Schell-model table", found, expected, half)
    # both sources have B_xy = 0: |S1|/S0 is all of the polarization
    degrees = [result["DoP"] for result in results]
    yield row("its degree of polarization", degrees, np.abs(expected), half)
