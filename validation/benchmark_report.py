"""The sections of the benchmark's report about errors, speed and starting, from its CSV files."""

from dataclasses import dataclass
from statistics import mean, median

from benchmark_stats import COMPONENTS, TARGET, geometric_mean, seconds, vanishes
from benchmark_tables import column, digits, groups, markdown

Rows = list[dict[str, str]]
Key = tuple[str, str, int]
# of the tables' rows: samples alike in every pixel, spread, and the peer's
PROGRAMS = ("brewster", "adaptive", "mitsuba")
TITLES = {
    "mono": "One wavelength (Mitsuba: `llvm_ad_mono_polarized`)",
    "spectral": "Luminance of all wavelengths (`--rgb`; Mitsuba: `llvm_ad_spectral_polarized`)",
}


@dataclass
class Cost:
    """What one component costs one program: error over mean S0, CPU seconds to the target."""

    error: float
    seconds: float
    median: float
    zero: bool
    from_scatter: bool


def costs(error: Rows, scatter: Rows, program: str) -> dict[Key, Cost]:
    """Return the costs by scene, mode and component, from the largest budget."""
    found: dict[Key, Cost] = {}
    between = {(r["scene"], r["mode"]): r for r in scatter if r["program"] == program}
    chosen = [r for r in error if r["program"] == program]
    for (scene, mode), rows in groups(chosen, "scene", "mode").items():
        most = max(column(rows, "spp"))
        rows = [r for r in rows if float(r["spp"]) == most]
        cpu, level = mean(column(rows, "cpu_s")), float(rows[0]["level"])
        for k in range(COMPONENTS):
            squares = column(rows, f"square{k}")
            square, middle = mean(squares), median(squares)
            spread = between.get((scene, mode))
            # a reference as noisy as this says less than the turns among each other
            noisy = spread is not None and 4 * float(rows[0][f"noise{k}"]) > square
            if noisy and spread:
                square = float(spread[f"scatter{k}"])
            found[scene, mode, k] = Cost(
                max(square, 0) ** 0.5 / level,
                *(seconds(cpu, s, level) for s in (square, middle)),
                vanishes(square, level),
                noisy,
            )
    return found


def equal_error(error: Rows, scatter: Rows, mode: str) -> str:
    """Return the table of CPU seconds to the target in one mode."""
    even, spread, theirs = (costs(error, scatter, name) for name in PROGRAMS)
    rows: list[list[str]] = []
    ratios: dict[str, list[float]] = {"even": [], "spread": []}
    resisting: dict[str, list[str]] = {"even": [], "spread": []}
    for (scene, at, k), our in even.items():
        adaptive, their = spread.get((scene, at, k)), theirs.get((scene, at, k))
        if at != mode or (our.zero and (their is None or their.zero)):
            continue
        every = [cost for cost in (our, adaptive, their) if cost]
        name = f"{scene} S{k}"
        row = [name + "*" * any(cost.from_scatter for cost in every)]
        for cost in (our, adaptive, their if theirs else None):
            row += [f"{cost.error:.3%}", digits(cost.seconds)] if cost else ["–", "–"]
        for kind, mine in (("even", our), ("spread", adaptive)):
            if not their or not mine:
                row += ["–", "–"] if theirs else []
            elif mine.zero or their.zero:
                row += ["exact", ""]
            else:
                ratio = their.seconds / mine.seconds
                row += [digits(ratio), digits(their.median / mine.median)]
                ratios[kind].append(ratio)
                if ratio < 1:
                    resisting[kind].append(name)
        rows.append(row)
    to = f"CPU s to {TARGET:.0%}"
    head = ["scene", "RMSE / mean S0", to, "`--adaptive`", to]
    if not theirs:
        rows = [row[: len(head)] for row in rows]
        return f"### {TITLES[mode]}\n\n{markdown(head, rows)}"
    head += ["Mitsuba", to, "ratio", "of medians", "adaptive: ratio", "of medians"]
    means = [f"**{digits(geometric_mean(ratios[kind]))}**" for kind in ("even", "spread")]
    rows.append(["**geometric mean**", *[""] * 6, means[0], "", means[1], ""])
    text = f"### {TITLES[mode]}\n\n{markdown(head, rows)}"
    for kind, words in (
        ("even", "the same number of samples in every pixel"),
        ("spread", "`--adaptive`"),
    ):
        slower = resisting[kind]
        text += (
            f"\nWith {words} Mitsuba is the faster one in {len(slower)} of {len(ratios[kind])} rows"
        )
        text += f": {', '.join(slower)}." if slower else "."
        others = geometric_mean(sorted(ratios[kind])[:-1])
        text += f" Without the largest ratio the geometric mean is {digits(others)}.\n"
    return text


def speed(rates: Rows) -> str:
    """Return the table of paths per core-second, the best of the turns."""

    def best(rows: Rows, what: str = "paths") -> float:
        return max(float(r[what]) / float(r["cpu_s"]) for r in rows) / 1e6

    by = groups(rates, "scene", "program", "mode")
    rows, ratios = [], {"mono": [], "spectral": []}
    beside = any(program == "mitsuba" for _, program, _ in by)
    for scene in dict.fromkeys(r["scene"] for r in rates):
        row = [scene]
        for mode, found in ratios.items():
            mine, other = (by.get((scene, p, mode)) for p in ("brewster", "mitsuba"))
            if mine is None:
                row += ["–"] * 4
                continue
            row += [digits(best(mine)), digits(best(mine, "rays"))]
            if other:
                found.append(best(mine) / best(other))
                row += [digits(best(other)), digits(found[-1])]
            elif beside:
                row += ["–", "–"]
        rows.append(row)
    head = ["scene"]
    for mode in ratios:
        head += [f"{mode}: paths", "rays"] + (["Mitsuba's paths", "ratio"] if beside else [])
    if beside:
        means = [f"**{digits(geometric_mean(found))}**" for found in ratios.values()]
        rows.append(["**geometric mean**", "", "", "", means[0], "", "", "", means[1]])
    return markdown(head, rows)


def start(rows: Rows) -> str:
    """Return the table of what comes before the first sample: seconds, CPU seconds."""

    def both(found: Rows, what: str, first: bool) -> str:
        chosen = [r for r in found if r["what"] == what and (r["turn"] == "0" or not first)]
        if not chosen:
            return "–"
        return f"{min(column(chosen, 'wall_s')):.2f} / {min(column(chosen, 'cpu_s')):.2f}"

    by = groups(rows, "scene", "program", "mode")
    table = []
    for scene in dict.fromkeys(r["scene"] for r in rows):
        cells = [scene, both(by[scene, "brewster", "mono"], "load", False)]
        for mode in TITLES:
            found = by.get((scene, "mitsuba", mode), [])
            cells += [both(found, "load", False), both(found, "compile", True)]
        table.append(cells)
    head = ["scene", "Brewster", "Mitsuba, mono: load", "compile", "spectral: load", "compile"]
    return markdown(head, table)
