"""Puts the benchmark's report together from the CSV files that are there."""

from pathlib import Path

import benchmark_growth as growth
import benchmark_report as report
import benchmark_tables as tables
import benchmark_theorem as theorem
from benchmark_plots import draw
from benchmark_stats import TARGET
from common import ROOT

HEAD = """# Benchmark

Error against CPU time, and how cost grows. Made by `validation/benchmark.py`, which needs
`validation/run.py` to have run once; every section names its command, version, time and machine.
All of it:

    validation/.venv/bin/python validation/benchmark.py --python ~/mitsuba/bin/python
"""
SUMMARY = """
Mitsuba's CPU seconds over Brewster's, and Brewster's paths per core-second over Mitsuba's: above 1
Brewster is faster. Over components a scene with four weighs more than one with three; over scenes
each counts once. The six scenes are grey: in `--rgb` Brewster then follows one wavelength and skips
the others ([how](skipping.md)), while Mitsuba follows four. The means of six over all wavelengths
so measure what skipping saves, not transport over a spectrum; `cornell_spectral`, whose walls and
metal are coloured, measures that, in lines of its own.
"""
ERROR = f"""
Each scene at its own film's size, or at the size that the command names. Brewster renders it twice:
with the same number of samples in every pixel, and with as many on the mean where the noise is
(`--adaptive`; [images.md](images.md#adaptive-sampling)). A turn renders every budget once in each
program and mode, the programs taking turns, with seeds of its own. RMSE is
√⟨(image − reference)² − Var reference⟩ over all pixels, mean of the turns; where the reference's
own variance is more than a quarter of it, marked *, it is the scatter between the turns. CPU
seconds are user and system time of all threads while sampling (Mitsuba: `mi.render` and the copy
to numpy), without loading, compiling and writing. CPU seconds to {TARGET:.0%} are those of the
largest budget × (RMSE/target)², target {TARGET} of mean S0. Components that vanish in both are
left out. Ratio: Mitsuba's seconds over Brewster's, above 1 Brewster is faster. Rare bright paths
make S0 of some scenes heavy-tailed, so that the ratio of the turns' medians stands beside it.

Six scenes are grey, so that in `--rgb` all wavelengths but one are skipped: their second table is
about skipping. `cornell_spectral` is coloured, and has a line in the second table alone: Mitsuba's
mono variants make one number of a spectrum, Brewster takes it at one wavelength. Means over
components are those of the six, then of all seven; the tables by scene count every scene once.
"""
SPEED = """
10⁶ a core-second at 256×256, 16 samples a pixel, the best of the turns. Paths are camera samples.
Here and below only ratios within a table count: between runs the machine and the number of samples
change the rates themselves by some tenths.
"""
BOUNDS = """
## What bounds it, and what would move it

**Meshes.** The rays of a mesh go down the tree one by one, eight boxes at a time, while paths wait
side by side ([how](wavefront.md)). Of the six scenes `big_mesh` alone has meshes, and has the
lowest ratio of paths per core-second; its S1 to S3 have the lowest ratios of time too, since there
little but the number of paths tells the programs apart. What would move it: several rays down the
tree together, sorted by direction, so that a node is fetched once for all of them.

**Rare paths.** In `cornell` more than nine tenths of the variance of S0 are caustics, light of the
lamp by way of the metal sphere or through the glass box onto matt walls: with white plaster in
place of both (the matte box below) it is gone. No connection to the lamp finds that light; a ray
that leaves a wall must hit sphere or box by chance, and then the lamp. In `rough_conductor` most of
it is light that the lamp sends by way of two metals, sphere and plate: at the one that it meets
first connection and lobe share the work (MIS), nothing guides the lobe of the other, which the path
meets before. Better points hardly help there.
What would move it: paths begun at the lamp too (bidirectional, or photons), connections through
smooth matter (manifolds), or directions learnt from earlier samples (guiding).

**`--adaptive`.** It divides samples so that all components that are not zero gain alike, each in
units of its own noise. What is best for S1 to S3, whose noise lies on metal and glass, is not best
for S0, whose noise in `cornell` lies everywhere; a quarter of the samples is even in any case. The
tables above name the components that it makes dearer. `--target-error S0=…` divides for S0 alone.
"""
START = """
Seconds / CPU seconds. Brewster: everything that is not sampling (loading, building, writing a
small image). Mitsuba: loading, and compiling with an empty cache of kernels (a first render
beyond a second one).
"""
POLARIZATION = """
CPU time of sampling with polarization over that of `--unpolarized`, of all bundled scenes at
256×256, with 1 to 16 samples a pixel as half a second allows, the two taking turns: at one
wavelength, in `--rgb` and in four bands (`--bands 400:700:4`). `matte box` is the Cornell box with
white plaster in place of metal and glass: nothing polarizes there.
"""
THREADS = """
One process with a thread a core against one process of one thread a core, all at once, 256 samples
a pixel; paths per second of the clock while sampling, the two taking turns.
"""
TRIANGLES = """
A displaced sphere of plastic over a matte floor under one lamp, 256×256, 16 samples; the picture
hardly changes with the number of triangles. Memory is the most that the process held, the text of
the file included.
"""
LAMPS = """
A plastic sphere on a floor under one lamp, or more that are together as large, spread over a
ceiling; 256×256, 16 samples. The error is what `--json` says: √(mean variance)/mean S0, worst
component.
"""
WAVELENGTHS = """
`--bands 400:700:N`, 128×128, 16 samples. One path carries up to four bands.
"""


def section(title: str, about: str, made: str, *texts: str) -> str:
    """Return a section with its origin."""
    command, _, rest = made.partition("; ")
    text = f"\n## {title}\n{about}\n    {command}\n\n{rest}.\n\n"
    return text + "\n".join(texts)


def compose(folder: Path) -> str:
    """Return the report, and draw its pictures."""
    text = HEAD
    made, error = tables.read(folder / "error.csv")
    if error:
        _, scatter = tables.read(folder / "scatter.csv")
        _, rates = tables.read(folder / "rates.csv")
        if means := report.summary(error, scatter, rates):
            text += section("In short", SUMMARY, made, means)
        pictures = [f"![{scene}](benchmark/{scene}.png)\n" for scene in draw(error, folder)]
        modes = [report.equal_error(error, scatter, mode) for mode in report.TITLES]
        text += section("Time to equal error", ERROR, made, *modes, *pictures)
    for title, about, name, table in (
        ("Paths per core-second", SPEED, "rates", report.speed),
        ("Before the first sample", START, "start", report.start),
        ("What polarization costs", POLARIZATION, "polarization", growth.polarization),
        ("Threads", THREADS, "threads", growth.threads),
        ("Triangles", TRIANGLES, "triangles", growth.triangles),
        ("Lamps", LAMPS, "lamps", lambda rows: growth.growth(rows, "lamps")),
        ("Wavelengths", WAVELENGTHS, "wavelengths", lambda rows: growth.growth(rows, "bands")),
    ):
        made, rows = tables.read(folder / f"{name}.csv")
        if rows:
            text += section(title, about, made, table(rows))
        if rows and name == "rates":
            text += BOUNDS
    return text + theorem.section(ROOT / "docs")
