"""Draws the benchmark's error against CPU time, one picture a scene."""

from pathlib import Path
from statistics import mean
from typing import TYPE_CHECKING

from benchmark_stats import COMPONENTS, TARGET, vanishes
from benchmark_tables import column, groups

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Rows = list[dict[str, str]]

# Okabe and Ito's colours: one a program; full lines for one wavelength
LOOKS = {
    ("brewster", "mono"): ("#0072B2", "o", "-", "Brewster, one wavelength"),
    ("brewster", "spectral"): ("#0072B2", "s", "--", "Brewster, luminance of --rgb"),
    ("adaptive", "mono"): ("#009E73", "o", "-", "Brewster --adaptive, one wavelength"),
    ("adaptive", "spectral"): ("#009E73", "s", "--", "Brewster --adaptive --rgb"),
    ("mitsuba", "mono"): ("#D55E00", "o", "-", "Mitsuba, llvm_ad_mono_polarized"),
    ("mitsuba", "spectral"): ("#D55E00", "s", "--", "Mitsuba, llvm_ad_spectral_polarized"),
}


def line(rows: Rows, k: int) -> tuple[list[float], list[float], list[tuple[float, float]]]:
    """Return CPU seconds and RMSE over mean S0 by budget, and the same of every turn."""
    seconds, errors, dots = [], [], []
    for _, turns in sorted(groups(rows, "spp").items(), key=lambda item: int(item[0][0])):
        level = float(turns[0]["level"])
        squares = column(turns, f"square{k}")
        if vanishes(mean(squares), level):
            continue
        seconds.append(mean(column(turns, "cpu_s")))
        errors.append(mean(squares) ** 0.5 / level)
        pairs = zip(column(turns, "cpu_s"), squares, strict=True)
        dots += [(cpu, square**0.5 / level) for cpu, square in pairs if square > 0]
    return seconds, errors, dots


def panel(axes: "Axes", rows: Rows, k: int) -> None:
    """Draw one component."""
    drawn = False
    for (program, mode), found in groups(rows, "program", "mode").items():
        colour, marker, style, _ = LOOKS[program, mode]
        seconds, errors, dots = line(found, k)
        if not errors:
            continue
        drawn = True
        axes.plot(
            seconds, errors, color=colour, marker=marker, markersize=4, linestyle=style,
            markerfacecolor=colour if style == "-" else "none",
        )  # fmt: skip
        axes.plot(*zip(*dots, strict=True), ".", color=colour, markersize=2, alpha=0.4)
    axes.set_title(f"S{k}", fontsize=10)
    axes.set_xlabel("CPU time of sampling, s")
    if not drawn:
        axes.text(0.5, 0.5, "zero", transform=axes.transAxes, ha="center", color="grey")
        axes.set_xticks([])
        axes.set_yticks([])
        return
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.axhline(TARGET, color="grey", linewidth=0.8, linestyle=":")
    axes.grid(which="major", linewidth=0.4, alpha=0.5)


def draw(error: Rows, folder: Path) -> list[str]:
    """Write one picture a scene; return their scenes."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    for (scene,), rows in groups(error, "scene").items():
        figure, panels = pyplot.subplots(1, COMPONENTS, figsize=(14, 4.2), layout="constrained")
        for k, axes in enumerate(panels):
            panel(axes, rows, k)
        panels[0].set_ylabel("RMSE / mean S0")
        figure.suptitle(f"{scene}: error against time", fontsize=11)
        shown = set(groups(rows, "program", "mode"))
        for key, (colour, marker, style, label) in LOOKS.items():
            if key in shown:
                panels[0].plot(
                    [], [], color=colour, marker=marker, markersize=4, linestyle=style,
                    markerfacecolor=colour if style == "-" else "none", label=label,
                )  # fmt: skip
        figure.legend(
            *panels[0].get_legend_handles_labels(), fontsize=8, ncols=3, loc="outside lower center"
        )
        figure.savefig(folder / f"{scene}.png", dpi=90)
        pyplot.close(figure)
    return [scene for (scene,) in groups(error, "scene")]
