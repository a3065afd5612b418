"""The section of the benchmark's report about the theorem's crates, from their CSV files."""

from pathlib import Path

import benchmark_tables as tables
from benchmark_tables import digits, markdown

Rows = list[dict[str, str]]
ORDERS = (0, 2, 4, 8, 16)
SERIES, INTERACTION = "run_time_against_error", "interaction_run_time"
ABOUT = """
Time against error over the order N of Hermite-Gauss series, in 64 and 32 bits, on one core. Both
files and both pictures, and the figures that the pages of the crates quote, are written by

    python3 validation/run_time_against_error.py
"""
SERIES_ABOUT = """
A Gaussian source over a shape of twice its variance, and a square one whose half-width is 4 σ of
the shape. ns to sum the series at one point, of 16 points at once for each, and to find its
coefficients; medians over rounds. Truncation is the L² error of the far field, rounding what 32
bits add at most, relative to the largest value.
"""
INTERACTION_ABOUT = """
What four channels make of the same Gaussian source, a transfer of Theorem S4.1: a surface of
moderate roughness (g = 10), whose autocorrelation is a sum of {} Gaussians, and a very rough one
(g = 1e4), of one. ns a transfer, medians over rounds. Truncation is the largest error of the lobe
against the whole source in 64 bits, rounding what 32 bits make of the same sum, both relative to
the largest value of the lobe.
"""
SOURCES = {"Gaussian": ("gaussian", "variance × 2"), "square": ("rectangle", "half-width 4 σ")}
TASKS = ("evaluate f64", "evaluate f32", "evaluate f32 16 points", "project")
LOBES = ("g = 10", "g = 1e4")


def shown(made: str) -> str:
    """Return a CSV's first line, without its command, as a sentence."""
    rest = made.partition("; ")[2]
    return f"{rest[:1].upper()}{rest[1:]}.\n"


def grown(first: list[float], last: list[float]) -> list[str]:
    """Return by how much each number grows from the first order to the last."""
    return [f"**× {digits(b / a)}**" for a, b in zip(first, last, strict=True)]


def series(rows: Rows) -> str:
    """Return the table of series: sums at a point, coefficients, errors."""
    table = []
    for what, source in SOURCES.items():
        of = {(r["task"], r["order"]): r for r in rows if (r["source"], r["width"]) == source}
        times = []
        for order in map(str, ORDERS):
            times.append([float(of[task, order]["ns"]) for task in TASKS])
            known = of[TASKS[0], order]
            errors = [f"{float(known[name]):.1e}" for name in ("l2_error", "f32_error")]
            table.append([f"{what}, {order}", *map(digits, times[-1]), *errors])
        growth = grown(times[0], times[-1])
        table.append([f"**{what}, {ORDERS[0]} to {ORDERS[-1]}**", *growth, "", ""])
    head = ["source, N", "sum, f64", "f32", "f32, of 16", "coefficients, f64"]
    return markdown([*head, "truncation", "rounding of f32"], table)


def interaction(rows: Rows) -> str:
    """Return the table of transfers: both precisions, both errors."""
    table = []
    for lobe in LOBES:
        times = []
        for order in map(str, ORDERS):
            names = (f"series; {lobe}", f"series in f32; {lobe}")
            pair = [
                next(r for r in rows if (r["name"], r["order"]) == (name, order)) for name in names
            ]
            times.append([float(row["ns"]) for row in pair])
            errors = (pair[0]["truncation"], pair[1]["rounding"])
            cells = [f"{float(error):.1e}" for error in errors]
            table.append([f"{lobe}, {order}", *map(digits, times[-1]), *cells])
        growth = grown(times[0], times[-1])
        table.append([f"**{lobe}, {ORDERS[0]} to {ORDERS[-1]}**", *growth, "", ""])
    return markdown(["roughness, N", "f64", "f32", "truncation", "rounding of f32"], table)


def section(docs: Path) -> str:
    """Return the section."""
    text = "\n## The theorem's crates\n" + ABOUT
    for name, title, table in (
        (SERIES, "Series", series),
        (INTERACTION, "Interaction", interaction),
    ):
        made, rows = tables.read(docs / f"{name}.csv")
        if not rows:
            continue
        about = SERIES_ABOUT
        if name == INTERACTION:
            terms = next(r["terms"] for r in rows if r["name"] == f"series; {LOBES[0]}")
            about = INTERACTION_ABOUT.format(terms)
        text += f"\n### {title}\n{about}\n{shown(made)}\n{table(rows)}"
        text += f"\n[{name}.csv]({name}.csv)\n\n![{name}]({name}.png)\n"
    return text
