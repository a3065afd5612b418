"""The sections of the benchmark's report about errors, speed and starting, from its CSV files."""

from dataclasses import dataclass
from statistics import mean, median

from benchmark_stats import COMPONENTS, TARGET, geometric_mean, seconds, vanishes
from benchmark_tables import column, digits, groups, markdown

Rows = list[dict[str, str]]
Key = tuple[str, str, int]
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
    trimmed: float
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
            trimmed = float(spread[f"trimmed{k}"]) if spread else float("nan")
            found[scene, mode, k] = Cost(
                max(square, 0) ** 0.5 / level,
                *(seconds(cpu, s, level) for s in (square, middle, trimmed)),
                vanishes(square, level),
                noisy,
            )
    return found


def equal_error(error: Rows, scatter: Rows, mode: str) -> str:
    """Return the table of CPU seconds to the target in one mode."""
    ours, theirs = (costs(error, scatter, program) for program in ("brewster", "mitsuba"))
    rows, ratios, robust, resisting = [], [], [], []
    for (scene, at, k), our in ours.items():
        if at != mode:
            continue
        their = theirs.get((scene, at, k))
        if our.zero and (their is None or their.zero):
            continue
        mark = "*" if our.from_scatter or (their and their.from_scatter) else ""
        row = [f"{scene} S{k}{mark}", f"{our.error:.3%}", digits(our.seconds)]
        if their:
            row += [f"{their.error:.3%}", digits(their.seconds)]
            if our.zero or their.zero:
                row += ["exact", "", ""]
            else:
                ratio = their.seconds / our.seconds
                row += [digits(ratio), digits(their.median / our.median)]
                row += [digits(their.trimmed / our.trimmed)]
                ratios.append(ratio)
                if their.trimmed / our.trimmed > 0:
                    robust.append(their.trimmed / our.trimmed)
                if ratio < 1:
                    resisting.append(f"{scene} S{k}")
        rows.append(row)
    head = ["scene", "RMSE / mean S0", f"CPU s to {TARGET:.0%}"]
    if theirs:
        head += ["Mitsuba's RMSE", f"CPU s to {TARGET:.0%}", "ratio", "of medians", "trimmed"]
        rows = [row + [""] * (len(head) - len(row)) for row in rows]
        middle = ["**geometric mean**", "", "", "", ""]
        rows.append([*middle, f"**{digits(geometric_mean(ratios))}**", "", ""])
        rows[-1][-1] = digits(geometric_mean(robust))
    text = f"### {TITLES[mode]}\n\n{markdown(head, rows)}"
    if theirs:
        text += f"\nMitsuba is the faster one in {len(resisting)} of {len(ratios)} rows"
        text += f": {', '.join(resisting)}.\n" if resisting else ".\n"
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
