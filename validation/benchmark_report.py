"""The sections of the benchmark's report about errors, speed and starting, from its CSV files."""

from dataclasses import dataclass
from statistics import mean, median

from benchmark_scenes import COLOURED
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


@dataclass
class Line:
    """One component of one scene: what it costs each program, and Mitsuba's seconds over ours."""

    scene: str
    component: int
    our: Cost
    adaptive: Cost | None
    their: Cost | None

    def name(self) -> str:
        """Return what it is called in tables."""
        return f"{self.scene} S{self.component}"

    def ratio(self, kind: str) -> float | None:
        """Return the ratio of even or spread samples, nothing of what has no error."""
        mine = self.our if kind == "even" else self.adaptive
        if not mine or not self.their or mine.zero or self.their.zero:
            return None
        return self.their.seconds / mine.seconds

    def cells(self, kind: str) -> list[str]:
        """Return that ratio and the one of the medians, as text."""
        mine, ratio = (self.our if kind == "even" else self.adaptive), self.ratio(kind)
        if not mine or not self.their:
            return ["–", "–"] if self.their or not mine else []
        if ratio is None:
            return ["exact", ""]
        return [digits(ratio), digits(self.their.median / mine.median)]


def compared(error: Rows, scatter: Rows, mode: str) -> list[Line]:
    """Return the components that do not vanish in both programs, in one mode."""
    even, spread, theirs = (costs(error, scatter, name) for name in PROGRAMS)
    lines = []
    for key, our in even.items():
        scene, at, k = key
        their = theirs.get(key)
        if at == mode and not (our.zero and (their is None or their.zero)):
            lines.append(Line(scene, k, our, spread.get(key), their))
    return lines


def ratios(lines: list[Line], kind: str, *, coloured: bool = False) -> list[float]:
    """Return the ratios of a kind, of grey scenes or of all."""
    chosen = (line.ratio(kind) for line in lines if coloured or line.scene not in COLOURED)
    return [ratio for ratio in chosen if ratio is not None]


def by_scene(lines: list[Line], kind: str, *, coloured: bool = False) -> dict[str, float]:
    """Return the geometric mean of each scene's ratios."""
    found = {}
    for scene in dict.fromkeys(line.scene for line in lines):
        known = ratios([line for line in lines if line.scene == scene], kind, coloured=coloured)
        if known:
            found[scene] = geometric_mean(known)
    return found


def equal_error(error: Rows, scatter: Rows, mode: str) -> str:
    """Return the tables of CPU seconds to the target in one mode."""
    lines = compared(error, scatter, mode)
    beside = any(line.their for line in lines)
    rows: list[list[str]] = []
    for line in lines:
        every = [cost for cost in (line.our, line.adaptive, line.their) if cost]
        row = [line.name() + "*" * any(cost.from_scatter for cost in every)]
        for cost in (line.our, line.adaptive, line.their if beside else None):
            row += [f"{cost.error:.3%}", digits(cost.seconds)] if cost else ["–", "–"]
        rows.append(row + line.cells("even") + line.cells("spread"))
    to = f"CPU s to {TARGET:.0%}"
    head = ["scene", "RMSE / mean S0", to, "`--adaptive`", to]
    if not beside:
        rows = [row[: len(head)] for row in rows]
        return f"### {TITLES[mode]}\n\n{markdown(head, rows)}"
    head += ["Mitsuba", to, "ratio", "of medians", "adaptive: ratio", "of medians"]
    extra = [scene for scene in COLOURED if any(line.scene == scene for line in lines)]
    for what, coloured in [("geometric mean", False), (f"with {', '.join(extra)}", True)]:
        if coloured and not extra:
            continue
        even, spread = (
            f"**{digits(geometric_mean(ratios(lines, kind, coloured=coloured)))}**"
            for kind in ("even", "spread")
        )
        rows.append([f"**{what}**", *[""] * 6, even, "", spread, ""])
    text = f"### {TITLES[mode]}\n\n{markdown(head, rows)}"
    for kind, words in (
        ("even", "the same number of samples in every pixel"),
        ("spread", "`--adaptive`"),
    ):
        known = [(line.name(), line.ratio(kind)) for line in lines]
        known = [(name, ratio) for name, ratio in known if ratio is not None]
        slower = [name for name, ratio in known if ratio < 1]
        text += f"\nWith {words} Mitsuba is the faster one in {len(slower)} of {len(known)} rows"
        text += f": {', '.join(slower)}." if slower else "."
        others = geometric_mean(sorted(ratios(lines, kind))[:-1])
        text += f" Without the largest ratio the geometric mean is {digits(others)}.\n"
    return text + worse_spread(lines) + "\n" + scenes_table(lines)


def worse_spread(lines: list[Line]) -> str:
    """Return which components `--adaptive` makes dearer."""
    worse = [
        line.name()
        for line in lines
        if line.adaptive and not line.our.zero and line.adaptive.seconds > line.our.seconds
    ]
    return f"\n`--adaptive` takes longer than even samples for {', '.join(worse) or 'none'}.\n"


def scenes_table(lines: list[Line]) -> str:
    """Return the table of ratios by scene, in which a scene counts once."""
    even, spread = (by_scene(lines, kind, coloured=True) for kind in ("even", "spread"))
    rows = []
    for scene in dict.fromkeys([*even, *spread]):
        count = sum(line.scene == scene and line.ratio("even") is not None for line in lines)
        pair = [digits(found[scene]) if scene in found else "–" for found in (even, spread)]
        rows.append([scene, str(count), *pair])
    extra = [scene for scene in COLOURED if scene in even]
    for what, coloured in [("geometric mean", False), (f"with {', '.join(extra)}", True)]:
        if coloured and not extra:
            continue
        pair = [
            f"**{digits(geometric_mean(list(by_scene(lines, kind, coloured=coloured).values())))}**"
            for kind in ("even", "spread")
        ]
        rows.append([f"**{what}**", "", *pair])
    head = ["geometric means by scene", "components", "ratio", "adaptive: ratio"]
    return markdown(head, rows)


def summary(error: Rows, scatter: Rows, rates: Rows) -> str:
    """Return the means of all sections in one table; nothing without Mitsuba's figures."""
    modes = {mode: compared(error, scatter, mode) for mode in TITLES}
    if not any(line.their for lines in modes.values() for line in lines):
        return ""
    columns = [("mono", False), ("spectral", False), ("spectral", True)]
    if not any(line.scene in COLOURED for line in modes["spectral"]):
        columns.pop()
    rows = []
    for kind, words in (
        ("spread", "samples where the noise is (`--adaptive`)"),
        ("even", "as many samples in every pixel"),
    ):
        by_rows, scenes = [], []
        for mode, coloured in columns:
            by_rows.append(digits(geometric_mean(ratios(modes[mode], kind, coloured=coloured))))
            each = by_scene(modes[mode], kind, coloured=coloured)
            scenes.append(digits(geometric_mean(list(each.values()))))
        rows.append([f"CPU time to {TARGET:.0%} error, {words}, over components", *by_rows])
        rows.append(["the same over scenes", *scenes])
    paths = [digits(geometric_mean(faster(rates, *column))) for column in columns]
    rows.append(["camera paths per core-second", *paths])
    head = ["geometric mean of Mitsuba's over Brewster's", "one wavelength", "all wavelengths"]
    return markdown([*head, f"with {', '.join(COLOURED)}"][: len(columns) + 1], rows)


def best(rows: Rows, what: str = "paths") -> float:
    """Return 10⁶ a core-second, the best of the turns."""
    return max(float(r[what]) / float(r["cpu_s"]) for r in rows) / 1e6


def faster(rates: Rows, mode: str, coloured: bool) -> list[float]:
    """Return our paths per core-second over Mitsuba's, scene by scene."""
    by = groups(rates, "scene", "program", "mode")
    found = []
    for scene in dict.fromkeys(r["scene"] for r in rates):
        mine, other = (by.get((scene, p, mode)) for p in ("brewster", "mitsuba"))
        if mine and other and (coloured or scene not in COLOURED):
            found.append(best(mine) / best(other))
    return found


def speed(rates: Rows) -> str:
    """Return the table of paths per core-second, the best of the turns."""
    by = groups(rates, "scene", "program", "mode")
    beside = any(program == "mitsuba" for _, program, _ in by)
    rows = []
    for scene in dict.fromkeys(r["scene"] for r in rates):
        row = [scene]
        for mode in TITLES:
            mine, other = (by.get((scene, p, mode)) for p in ("brewster", "mitsuba"))
            row += [digits(best(mine)), digits(best(mine, "rays"))] if mine else ["–", "–"]
            if beside:
                both = bool(mine and other)
                row += (
                    [digits(best(other)), digits(best(mine) / best(other))] if both else ["–"] * 2
                )
        rows.append(row)
    head = ["scene"]
    for mode in TITLES:
        head += [f"{mode}: paths", "rays"] + (["Mitsuba's paths", "ratio"] if beside else [])
    extra = [scene for scene in COLOURED if any(row[0] == scene for row in rows)]
    if beside:
        means = [digits(geometric_mean(faster(rates, mode, False))) for mode in TITLES]
        cells = [cell for text in means for cell in ("", "", "", f"**{text}**")]
        rows.append(["**geometric mean**", *cells])
        if extra:
            mean_of_all = digits(geometric_mean(faster(rates, "spectral", True)))
            rows.append([f"**with {', '.join(extra)}**", *[""] * 7, f"**{mean_of_all}**"])
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
        ours = [by[key] for mode in TITLES if (key := (scene, "brewster", mode)) in by]
        cells = [scene, both(ours[0], "load", False)]
        for mode in TITLES:
            found = by.get((scene, "mitsuba", mode), [])
            cells += [both(found, "load", False), both(found, "compile", True)]
        table.append(cells)
    head = ["scene", "Brewster", "Mitsuba, mono: load", "compile", "spectral: load", "compile"]
    return markdown(head, table)
