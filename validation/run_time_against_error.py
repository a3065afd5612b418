#!/usr/bin/env python3
"""Time against error of Hermite-Gauss series and of the interaction: measures and draws.

    python3 validation/run_time_against_error.py [-o DIR]

Runs the examples `run_time_against_error` of crate `stokes` and `interaction_run_time` of crate
`mueller16` (release build) and writes a .csv, whose first line says when and where, and a .png of
each name to docs/, or to DIR.  Into docs/ means: the tables that the crates' pages quote are
written anew too, and `benchmark.py report` afterwards puts tables of it into docs/benchmark.md.
`--csv FILE` draws an earlier CSV of the first instead of measuring, `--interaction-csv FILE` one of
the second.  Needs what run.py needs and uses its virtual environment.  Measure on a quiet machine:
the figures are medians of rounds in which the contestants take turns, so that ratios hold on a busy
one too, but times do not.
"""

import argparse
import csv
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import origin
import run

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NAME = "run_time_against_error"
EXAMPLE = ["cargo", "run", "--release", "-p", "stokes", "--example", NAME, "--"]

INTERACTION = "interaction_run_time"
INTERACTION_EXAMPLE = [
    "cargo", "run", "--release", "-p", "mueller16", "--example", INTERACTION, "--",
]  # fmt: skip

Row = dict[str, str]

# what the parts of the interaction's table are called in its picture
PARTS = {
    "order": "order", "rough": "powers", "heights": "chosen", "grating": "grating",
}  # fmt: skip

# Okabe and Ito's colours, and a marker of its own for each source
SOURCES = {
    ("gaussian", "variance × 2"): ("#0072B2", "o", "-", "Gaussian, shape's variance × 2"),
    ("rectangle", "variance matched"): ("#D55E00", "s", "-", "rectangle, variance matched"),
    ("rectangle", "half-width 4 σ"): ("#D55E00", "s", "--", "rectangle, half-width 4 σ"),
    ("disk", "variance matched"): ("#009E73", "^", "-", "disk, variance matched"),
    ("disk", "half-width 4 σ"): ("#009E73", "^", "--", "disk, radius 4 σ"),
}
# the lines of the right panel: one width a source, the better one at high order
DRAWN = [("gaussian", "variance × 2"), ("rectangle", "half-width 4 σ"), ("disk", "half-width 4 σ")]
# where the right panel ends
LEAST_ERROR = 1e-5
TASKS = {
    "project": ("-", "full", "coefficients of the source, f64"),
    "evaluate f64": ("--", "full", "series at one point, f64"),
    "evaluate f32": (":", "none", "series at one point, f32"),
    "evaluate f32 16 points": ("-.", "none", "series at 16 points at once, f32, per point"),
}


def in_environment() -> None:
    """Prepare the virtual environment and go on inside it."""
    run.prepare()
    if Path(sys.prefix).resolve() != run.VENV.resolve():
        os.execv(run.PYTHON, [str(run.PYTHON), str(Path(__file__).resolve()), *sys.argv[1:]])


def fail(reason: str) -> NoReturn:
    """Say why there is no picture, and leave with status 2."""
    print(f"{NAME}: {reason}", file=sys.stderr)
    sys.exit(2)


def of_source(rows: list[Row], task: str, source: tuple[str, str]) -> list[Row]:
    """Return the rows of one line, by order."""
    found = [r for r in rows if r["task"] == task and (r["source"], r["width"]) == source]
    if not found:
        fail(f"the CSV has no rows of '{task}' for '{', '.join(source)}'")
    return sorted(found, key=lambda r: int(r["order"]))


def draw_errors(axes: "Axes", rows: list[Row]) -> None:
    """Draw both errors against the order."""
    for source, (colour, marker, style, label) in SOURCES.items():
        line = of_source(rows, "project", source)
        orders = [int(r["order"]) for r in line]
        look = {"color": colour, "marker": marker, "markersize": 4, "linestyle": style}
        axes.plot(orders, [float(r["l2_error"]) for r in line], label=label, **look)
        at_zero = [abs(float(r["error_at_zero"])) for r in line]
        look |= {"markerfacecolor": "none", "linewidth": 0.6, "alpha": 0.65}
        axes.plot(orders, at_zero, **look)
    axes.plot([], [], color="grey", marker="o", markersize=4, label="filled: L² error / |f|")
    axes.plot(
        [], [], color="grey", marker="o", markersize=4, markerfacecolor="none", linewidth=0.6,
        label="open: |error of f(0)| / f(0)",
    )  # fmt: skip
    rounding = [r for r in rows if r["task"] == "evaluate f32"]
    axes.plot(
        sorted({int(r["order"]) for r in rounding}),
        [
            max(float(r["f32_error"]) for r in rounding if int(r["order"]) == order)
            for order in sorted({int(r["order"]) for r in rounding})
        ],
        color="black", linestyle=":", label="rounding of f32, worst source",
    )  # fmt: skip
    axes.set_xscale("symlog", base=2, linthresh=1)
    axes.set_yscale("log")
    axes.set_ylim(1e-8, 2)
    ticks = [0, 1, 2, 4, 8, 16, 32, 64]
    axes.set_xticks(ticks, [str(t) for t in ticks])
    axes.set_xlabel("order N of the series")
    axes.set_ylabel("relative error")
    axes.legend(fontsize=7, handlelength=3.5, loc="center left")


def draw_times(axes: "Axes", rows: list[Row]) -> None:
    """Draw time against L² error."""
    for source in DRAWN:
        colour, marker, _, _ = SOURCES[source]
        for task, (style, fill, _) in TASKS.items():
            line = [
                r
                for r in of_source(rows, task, source)
                # these sources have no odd orders
                if float(r["l2_error"]) >= LEAST_ERROR and int(r["order"]) % 2 == 0
            ]
            axes.plot(
                [float(r["l2_error"]) for r in line], [float(r["ns"]) for r in line],
                color=colour, marker=marker, markersize=4, linestyle=style,
                markerfacecolor=colour if fill == "full" else "none",
            )  # fmt: skip
    for source in DRAWN:
        colour, marker, _, label = SOURCES[source]
        axes.plot([], [], color=colour, marker=marker, markersize=4, label=label)
    for style, _, label in TASKS.values():
        axes.plot([], [], color="grey", linestyle=style, label=label)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.invert_xaxis()
    axes.set_xlabel("L² error / |f| (N = 0, 2, 4, 6, 8, 12, 16 … along each line)")
    axes.set_ylabel("time, ns")
    axes.legend(fontsize=7, handlelength=3.5, loc="upper right")


def draw(rows: list[Row], png: Path) -> None:
    """Draw both panels."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(12, 5.2), layout="constrained")
    draw_errors(left, rows)
    left.set_title("error of a truncated far field", fontsize=10)
    draw_times(right, rows)
    right.set_title("time against error, one core", fontsize=10)
    for axes in (left, right):
        axes.grid(which="major", linewidth=0.4, alpha=0.5)
    figure.savefig(png, dpi=110)


def whole_error(row: Row) -> float:
    """Return truncation and rounding of the interaction together."""
    return float(row["truncation"]) + float(row["rounding"] or 0)


def draw_interaction(rows: list[Row], png: Path) -> None:
    """Draw time against error of the interaction, and what is gained by what is absent."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(13, 5.6), layout="constrained")
    # one colour a roughness: filled where the Gaussians are chosen, hollow where powers are summed;
    # one a series too, crosses in f32
    colours: dict[str, object] = {}
    for part, style, marker in (
        ("order", "-", "o"), ("rough", ":", "s"), ("heights", "--", "D"), ("grating", "-.", "^"),
    ):  # fmt: skip
        drawn = [r for r in rows if r["part"] == part and r["truncation"]]
        for name in dict.fromkeys(r["name"] for r in drawn):
            line = [r for r in drawn if r["name"] == name and whole_error(r) > 0]
            single = "f32" in {r["number"] for r in line}
            of_series = name.replace(" in f32", "")
            # the last row of a rough surface is the limit of great roughness, no sum
            if part == "rough":
                line = line[:-1]
            (curve,) = left.plot(
                [whole_error(r) for r in line], [float(r["least_ns"]) for r in line],
                linestyle=":" if single else style, marker="x" if single else marker,
                markersize=4, color=colours.get(of_series),
                markerfacecolor="none" if part == "rough" else None,
                label=f"{PARTS[part]}: {name}",
            )  # fmt: skip
            colours[of_series] = curve.get_color()
    left.set_xscale("log")
    left.set_yscale("log")
    left.invert_xaxis()
    left.set_xlabel("largest error / largest value of the lobe (truncation + rounding)")
    left.set_ylabel("time of a transfer, ns (least over rounds)")
    left.legend(fontsize=6, ncols=2, loc="upper center")
    left.set_ylim(top=4e5)
    left.set_title("time against error: order, Gaussians, orders of a grating", fontsize=10)
    bars = [r for r in rows if r["part"] in ("yardstick", "channels", "skip", "layers")]
    labels = [f"{r['part']}: {r['name']}, N = {r['order']}" for r in bars]
    places = range(len(bars))
    right.barh(places, [float(r["least_ns"]) for r in bars], color="#0072B2")
    right.set_yticks(places, labels, fontsize=7)
    right.invert_yaxis()
    right.set_xscale("log")
    right.set_xlabel("time of a transfer, ns (least over rounds)")
    right.set_title("yardsticks, and what is gained by what is absent", fontsize=10)
    for axes in (left, right):
        axes.grid(which="major", linewidth=0.4, alpha=0.5)
    figure.savefig(png, dpi=110)


def stamp(table: Path, made: str) -> None:
    """Add when and where it was measured to the first line of a CSV."""
    first, _, rest = table.read_text(encoding="utf-8").partition("\n")
    table.write_text(f"{first}; {made}\n{rest}", encoding="utf-8")


def short(value: float) -> str:
    """Return two digits, whole numbers from ten on; the crates' tests ask for as many."""
    if value >= 9.95:
        return f"{value:.0f}"
    if value >= 1e-3:
        return f"{value:#.2g}"
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    return f"{mantissa}e{int(exponent)}"


def quote_series(line: str, rows: list[Row]) -> str:
    """Return a row of the table of crate `stokes` with the figures of `rows`."""
    cells = line.strip().split("|")[1:-1]
    if len(cells) != 6 or not cells[0].strip().isdigit():
        return line
    order = cells[0].strip()
    of = {(r["task"], r["source"], r["width"]): r for r in rows if r["order"] == order}
    gaussian, square = ("gaussian", "variance × 2"), ("rectangle", "half-width 4 σ")
    figures = [
        float(of["evaluate f64", *gaussian]["ns"]),
        float(of["evaluate f32 16 points", *gaussian]["ns"]),
        float(of["project", *square]["ns"]) * 1e-3,
        *(float(of["project", *source]["l2_error"]) for source in (gaussian, square)),
    ]
    return f"//! | {' | '.join([order, *map(short, figures)])} |"


def quote_interaction(line: str, rows: list[Row]) -> str:
    """Return a row of the table of crate `mueller16` with the figures of `rows`."""
    cells = [cell.strip() for cell in line.split("|")[1:-1]]
    for row in rows:
        if len(cells) == 4 and cells[:3] == [row["part"], row["name"], row["order"]]:
            indent = line[: line.index("///")]
            return f"{indent}/// | {' | '.join(cells[:3])} | {float(row['least_ns']):.0f} |"
    return line


def quote(page: Path, rows: list[Row], quoted: Callable[[str, list[Row]], str]) -> None:
    """Write the figures that a page of Rust quotes anew."""
    lines = page.read_text(encoding="utf-8").splitlines()
    comment = ("//! |", "/// |")
    new = [quoted(line, rows) if line.strip().startswith(comment) else line for line in lines]
    page.write_text("\n".join(new) + "\n", encoding="utf-8")


def rows_of(example: list[str], given: Path | None, table: Path) -> list[Row]:
    """Measure, or copy an earlier CSV, and return its rows."""
    if given is None:
        # the load of others, not of the build
        made = origin.made(f"crate {example[example.index('-p') + 1]}")
        if subprocess.run([*example, str(table)], cwd=run.ROOT).returncode != 0:
            fail("the example failed")
        stamp(table, made)
    elif given.resolve() != table:
        shutil.copyfile(given, table)
    with table.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def main() -> int:
    """Measure, copy, draw."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", metavar="DIR", type=Path, default=run.ROOT / "docs")
    parser.add_argument("--csv", metavar="FILE", type=Path, help="draw this one, measure nothing")
    parser.add_argument(
        "--interaction-csv", metavar="FILE", type=Path, help="the same for the interaction"
    )
    args = parser.parse_args()
    in_environment()
    args.o.mkdir(parents=True, exist_ok=True)
    crates = run.ROOT / "crates"
    for name, example, given, picture, page, quoted in (
        (NAME, EXAMPLE, args.csv, draw, crates / "stokes/src/lib.rs", quote_series),
        (
            INTERACTION, INTERACTION_EXAMPLE, args.interaction_csv, draw_interaction,
            crates / "mueller16/src/theorem.rs", quote_interaction,
        ),
    ):  # fmt: skip
        table = (args.o / f"{name}.csv").resolve()
        rows = rows_of(example, given, table)
        if table.parent == (run.ROOT / "docs").resolve():
            quote(page, rows, quoted)
        png = table.with_suffix(".png")
        picture(rows, png)
        print(f"wrote {table} and {png}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
