"""Hermite-Gauss functions, their changes of root and their transforms against quadrature."""

import numpy as np
from evaluate import Case, Program
from hermite_gauss import from_generating_function, hermite_table, symmetric_power
from light_grids import (
    EPS,
    ROOTS,
    SHAPES,
    STEP,
    Rows,
    gauss_grid,
    grid,
    largest,
    modes,
    moved,
    turn,
)
from mpmath import mp


def orthonormal_on_the_line(program: Program) -> Rows:
    """∫ h_n h_k dt = δ for orders up to 256."""
    orders = [0, 1, 2, 7, 31, 63, 64, 127, 128, 255, 256]
    step = 0.08
    # h_256 is below 1e-20 beyond 28
    t = np.arange(-350, 351) * step
    cases: list[Case] = [("hermite1d", {"n": n, "t": x}) for n in orders for x in t]
    h = program.values(cases).reshape(len(orders), -1)
    gram = step * h @ h.T
    error = np.abs(gram - np.eye(len(orders))).max()
    yield "⟨h_n|h_k⟩, n ≤ 256", error, 2 * STEP * EPS * (orders[-1] + 10)


def orthonormal_in_the_plane(program: Program) -> Rows:
    """∫ φ_ab φ_cd d²x = δ, by a Gauss rule that is exact for these orders."""
    order = 6
    y, weight = gauss_grid(order + 3)
    pairs = modes(order)
    cases: list[Case] = []
    for w in ROOTS.values():
        x = np.linalg.solve(w, y.T).T
        cases += [("phi", {"a": a, "b": b, "W": w, "x": p}) for a, b in pairs for p in x]
    values = program.values(cases).reshape(len(ROOTS), len(pairs), -1)
    for (name, w), phi in zip(ROOTS.items(), values, strict=True):
        gram = (phi * weight) @ phi.T / abs(np.linalg.det(w))
        error = np.abs(gram - np.eye(len(pairs))).max()
        yield f"⟨φ_ab|φ_cd⟩, {name}", error, 2 * moved(y, order) * np.linalg.cond(w)


def biorthogonal(program: Program) -> Rows:
    """∫ Ψ_nm Ψ̃_kl d²x = δ, relative to the norms of the two."""
    order = 5
    y, weight = gauss_grid(order + 3)
    pairs = modes(order)
    cases: list[Case] = []
    for theta in SHAPES.values():
        x = y @ np.linalg.cholesky(theta).T
        cases += [
            ("psi", {"n": n, "m": m, "Theta": theta, "x": p, "dual": dual})
            for dual in (0, 1)
            for n, m in pairs
            for p in x
        ]
    values = program.values(cases).reshape(len(SHAPES), 2, len(pairs), -1)
    for (name, theta), (psi, dual) in zip(SHAPES.items(), values, strict=True):
        area = np.sqrt(np.linalg.det(theta))
        gram = (psi * weight) @ dual.T * area
        norms = area * np.sqrt(np.outer((psi**2) @ weight, (dual**2) @ weight))
        error = (np.abs(gram - np.eye(len(pairs))) / norms).max()
        yield f"⟨Ψ|Ψ̃⟩, {name}", error, 2 * moved(y, order) * np.linalg.cond(theta)


def generating_function(program: Program) -> Rows:
    """Ψ, its dual and Ψ(0) by Cauchy's integral of their generating functions."""
    order = 6
    pairs = modes(order)
    rng = np.random.default_rng(1)
    for name, theta in SHAPES.items():
        points = rng.normal(size=(4, 2)) @ np.linalg.cholesky(theta).T
        for dual in (0, 1):
            cases: list[Case] = [
                ("psi", {"n": n, "m": m, "Theta": theta, "x": x, "dual": dual})
                for x in points
                for n, m in pairs
            ]
            found = program.values(cases).reshape(len(points), -1)
            error = 0.0
            for x, row in zip(points, found, strict=True):
                table, scale = from_generating_function(order, theta, x, dual=bool(dual))
                error = largest(
                    error,
                    *(abs(v - table[p]) / scale[p] for p, v in zip(pairs, row, strict=True)),
                )
            bound = moved(np.array(3.0), order) * np.linalg.cond(theta)
            yield f"{'Ψ̃' if dual else 'Ψ'}, {name}", error, bound
        table, scale = from_generating_function(order, theta, np.zeros(2), dual=False)
        found = program.values([("psi_zero", {"n": n, "m": m, "Theta": theta}) for n, m in pairs])
        error = largest(abs(v - table[p]) / scale[p] for p, v in zip(pairs, found, strict=True))
        yield f"Ψ(0), {name}", error, moved(np.array(0.0), order) * np.linalg.cond(theta)


def fourier_pair(program: Program) -> Rows:
    """F{Ψ}(ζ) and F{Ψ̃}(ζ) by quadrature of Ψ and Ψ̃."""
    pairs = [(0, 0), (1, 0), (0, 1), (2, 1), (1, 3), (4, 2)]
    y, weight = grid(10.0, 0.55)
    rng = np.random.default_rng(2)
    for name in ("cond 30", "cond 1e4"):
        theta = SHAPES[name]
        factor = np.linalg.cholesky(theta)
        x = y @ factor.T
        zeta = rng.normal(size=(5, 2)) @ np.linalg.inv(factor)
        for dual in (0, 1):
            common = {"Theta": theta, "dual": dual}
            cases: list[Case] = [
                ("psi", {"n": n, "m": m, "x": p, **common}) for n, m in pairs for p in x
            ]
            psi = program.values(cases).reshape(len(pairs), -1)
            weights = weight * np.linalg.det(factor)
            expected = weights * psi @ np.exp(-1j * x @ zeta.T)
            scale = weights * np.abs(psi).sum(-1, keepdims=True)
            cases = [
                ("ft_psi", {"n": n, "m": m, "zeta": z, **common}) for n, m in pairs for z in zeta
            ]
            found = program.values(cases).reshape(len(pairs), -1)
            error = (np.abs(found - expected) / scale).max()
            bound = moved(np.array(9.5), 6) * np.linalg.cond(theta)
            yield f"F{{{'Ψ̃' if dual else 'Ψ'}}}, {name}", error, bound


def parity(program: Program) -> Rows:
    """f(−x) = (−1)^(n+m) f(x), digit for digit."""
    x = np.array([0.7, -1.3])
    kinds = [
        ("phi", ("a", "b"), {"W": ROOTS["cond Θ 1e2, turned"]}),
        ("psi", ("n", "m"), {"Theta": SHAPES["cond 30"], "dual": 0}),
        ("psi", ("n", "m"), {"Theta": SHAPES["cond 30"], "dual": 1}),
    ]
    worst = 0.0
    for op, names, common in kinds:
        pairs = modes(8)
        sides = [
            program.values(
                [(op, {**dict(zip(names, p, strict=True)), **common, "x": s * x}) for p in pairs]
            )
            for s in (1, -1)
        ]
        signs = np.array([(-1) ** (a + b) for a, b in pairs])
        worst = largest(worst, np.abs(sides[0] - signs * sides[1]).max())
    yield "parity of φ, Ψ and Ψ̃", worst, 0.0


def overlaps(program: Program) -> Rows:
    """⟨φ_ab(·; W1)|φ_nm(·; W2)⟩ by quadrature."""
    orders = [(0, 0), (1, 0), (0, 2), (3, 1), (4, 4), (8, 0), (5, 7), (0, 12)]
    pairs = [("cond Θ 1e2, turned", "round"), ("mirrored", "cond Θ 1e2, turned")]
    y, weight = grid(11.0, 0.06)
    for first, second in pairs:
        w1, w2 = ROOTS[first], ROOTS[second]
        cases: list[Case] = [
            ("overlap", {"a": a, "b": b, "n": n, "m": m, "W1": w1, "W2": w2})
            for a, b in orders
            for n, m in orders
        ]
        found = program.values(cases)
        k = np.linalg.cholesky(np.linalg.inv(w1.T @ w1 + w2.T @ w2))
        x = np.sqrt(2) * y @ k.T
        tables = []
        for w in (w1, w2):
            h = hermite_table(12, (x @ w.T).T)
            tables.append(np.array([h[a, 0] * h[b, 1] for a, b in orders]))
        size = np.sqrt(abs(np.linalg.det(w1) * np.linalg.det(w2)))
        area = 2 * weight * np.linalg.det(k) * size
        expected = (area * tables[0] @ tables[1].T).ravel()
        scale = (area * np.abs(tables[0]) @ np.abs(tables[1]).T).max()
        condition = np.linalg.cond(w1) * np.linalg.cond(w2)
        bound = moved(np.array(11.0), 24) * condition * max(scale, 1)
        yield f"overlap, {first} | {second}", np.abs(found - expected).max(), bound


def symmetric_powers(program: Program) -> Rows:
    """Sym^N(A) by expansion of the polynomials with 60 digits, relative to |A|^N."""
    rng = np.random.default_rng(5)
    matrices = [turn(0.7), turn(-2.0), *rng.normal(size=(4, 2, 2)), np.diag([1.0, 1e-5])]
    orders = [0, 1, 2, 3, 8, 20, 40]
    cases: list[Case] = [("sym_power", {"A": a, "N": n}) for a in matrices for n in orders]
    worst = 0.0
    with mp.workdps(60):
        for (_, inputs), found in zip(cases, program(cases), strict=True):
            a, n = inputs["A"], inputs["N"]
            expected = np.array(symmetric_power([[mp.mpf(v) for v in r] for r in a], n), float)
            error = np.abs(np.array(found["matrix"]) - expected).max() / np.linalg.norm(a, 2) ** n
            worst = largest(worst, error / (n + 1))
    yield "Sym^N(A), N ≤ 40, over (N + 1)|A|^N", worst, STEP * EPS


def same_function(program: Program) -> Rows:
    """Σ c_nm Ψ_nm = Σ c_ab φ_ab where cov_to_white made the latter from the former."""
    order = 6
    pairs = modes(order)
    rng = np.random.default_rng(6)
    for name in ("cond Θ 1e2, turned", "mirrored"):
        w = ROOTS[name]
        theta = np.linalg.inv(w.T @ w)
        theta[1, 0] = theta[0, 1]
        coefficients = [rng.normal(size=n + 1) for n in range(order + 1)]
        [white] = program([("cov_to_white", {"W": w, "coeffs": coefficients})])
        points = np.linalg.solve(w, rng.normal(size=(2, 8))).T
        flat = np.concatenate(coefficients)
        psi = program.values(
            [
                ("psi", {"n": n, "m": m, "Theta": theta, "x": x, "dual": 0})
                for x in points
                for n, m in pairs
            ]
        ).reshape(len(points), -1)
        phi = program.values(
            [("phi", {"a": a, "b": b, "W": w, "x": x}) for x in points for a, b in pairs]
        ).reshape(len(points), -1)
        expected, found = psi @ flat, phi @ np.concatenate(white["coeffs_white"])
        scale = (np.abs(psi) @ np.abs(flat)).max()
        bound = moved(np.array(3.0), order) * np.linalg.cond(theta)
        yield f"cov_to_white, {name}", np.abs(expected - found).max() / scale, bound
        error = np.abs(np.array(white["Theta"]) - theta).max() / np.abs(theta).max()
        yield f"  its Θ, {name}", error, STEP * EPS * np.linalg.cond(theta)
