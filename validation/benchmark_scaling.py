"""How Brewster's cost grows: with polarization, threads, triangles, lamps and wavelengths.

Everything that is compared takes turns in one run.  Times are CPU seconds of sampling over all
threads where nothing else is said.
"""

import os
import tempfile
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from benchmark_runs import alone, side_by_side
from benchmark_scenes import lamp_scene, matte_box, mesh_scene
from benchmark_stats import TARGET
from common import SCENES

Row = dict[str, Any]
SIZE, PIXELS = ["--size", "256x256"], 256 * 256
TRIANGLES = [2_000, 20_000, 200_000, 2_000_000]
LAMPS = [1, 3, 10, 30, 100, 300, 1000]
BANDS = [1, 2, 4, 8, 16, 32, 64]
# measured over bands: plain numbers, and matter whose indices follow the wavelength
BANDED = ["rough_conductor", "cornell_spectral"]
# samples a pixel; of threads more, since renderings of a twentieth of a second do not tell
SPP = 16
THREADS_SPP = 256
# what polarization costs is measured of each, where scenes differ, in about so many CPU seconds
RANGES = {"one wavelength": [], "--rgb": ["--rgb"], "--bands": ["--bands", "400:700:4"]}
ENOUGH_S = 0.5


def polarization(scenes: list[str], turns: int) -> list[Row]:
    """Time each scene with polarization and without, and a box where nothing polarizes."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = {scene: SCENES / scene / "scene.xml" for scene in scenes}
        files["matte box"] = matte_box(folder)
        for (scene, file), (mode, of_mode) in product(files.items(), RANGES.items()):
            spp = samples(file, folder, of_mode)
            print(f"{scene}, {mode}: {spp} samples", flush=True)
            for turn in range(turns):
                options = [*SIZE, *of_mode, "--spp", str(spp), "--seed", str(turn)]
                kinds = ([], ["--unpolarized"])[:: -1 if turn % 2 else 1]
                cpu = {len(kind): alone(file, folder, *options, *kind) for kind in kinds}
                row = {"scene": scene, "mode": mode, "turn": turn, "paths": cpu[0].told["paths"]}
                row |= {"cpu_s": cpu[0].cpu(), "unpolarized_cpu_s": cpu[1].cpu()}
                rows.append(row)
    return rows


def samples(file: Path, folder: Path, options: list[str]) -> int:
    """Return a power of two of samples a pixel that takes about `ENOUGH_S`, at most `SPP`."""
    trial = alone(file, folder, *options, "--size", "64x64", "--spp", "4")
    wanted = ENOUGH_S * trial.per_core_second() / PIXELS
    return int(np.clip(2 ** np.floor(np.log2(wanted)), 1, SPP))


def threads(scenes: list[str], turns: int) -> list[Row]:
    """Time all cores in one process against as many processes of one thread at once."""
    cores = os.cpu_count() or 1
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for scene in scenes:
            file = SCENES / scene / "scene.xml"
            for turn in range(turns):
                options = [*SIZE, "--spp", str(THREADS_SPP)]
                one = alone(file, folder, *options, "--threads", str(cores))
                many = side_by_side(cores, file, folder, *options, "--threads", "1")
                row = {"scene": scene, "turn": turn, "threads": cores}
                row |= {"together_per_s": one.per_second()}
                row |= {"processes_per_s": sum(run.per_second() for run in many)}
                row |= {"together_per_core_s": one.per_core_second()}
                rows.append(row | {"processes_per_core_s": many[0].per_core_second()})
    return rows


def over(
    what: str,
    counts: list[int],
    turns: int,
    case: Callable[[Path, int], tuple[Path, Row, list[str]]],
) -> list[Row]:
    """Render one case a count, the counts taking turns; `case` writes the scene."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        cases = {}
        for count in counts:
            folder = Path(name) / str(count)
            folder.mkdir()
            cases[count] = (folder, *case(folder, count))
        for turn in range(turns):
            for count, (folder, scene, about, options) in cases.items():
                run = alone(scene, folder, "--spp", str(SPP), "--seed", str(turn), *options)
                wall, cpu = run.start()
                row = {what: count, **about, "turn": turn, "paths": run.told["paths"]}
                row |= {"rays": run.told["rays"], "cpu_s": run.cpu(), "error": run.told["error"]}
                row |= {"to_target_s": run.cpu() * (run.told["error"] / TARGET) ** 2}
                row |= {"start_wall_s": wall, "start_cpu_s": cpu, "memory": run.memory}
                rows.append(row)
    return rows


def triangles(turns: int, largest: int = TRIANGLES[-1]) -> list[Row]:
    """Time meshes of growing size on the same picture."""

    def case(folder: Path, count: int) -> tuple[Path, Row, list[str]]:
        scene, exact = mesh_scene(folder, count)
        size = (folder / "mesh.obj").stat().st_size
        return scene, {"triangles": exact, "file": size}, SIZE

    return over("wanted", [n for n in TRIANGLES if n <= largest], turns, case)


def lamps(turns: int) -> list[Row]:
    """Time the same light from more and more lamps."""

    def case(folder: Path, count: int) -> tuple[Path, Row, list[str]]:
        return lamp_scene(folder, count), {}, SIZE

    return over("lamps", LAMPS, turns, case)


def wavelengths(turns: int) -> list[Row]:
    """Time one band and more, of two scenes."""
    rows = []
    for name in BANDED:

        def case(_: Path, count: int, name: str = name) -> tuple[Path, Row, list[str]]:
            bands = ["--bands", f"400:700:{count}"]
            return SCENES / name / "scene.xml", {"scene": name}, [*bands, "--size", "128x128"]

        rows += over("bands", BANDS, turns, case)
    return rows


def memory_of_a_triangle(rows: list[Row]) -> float:
    """Return bytes a triangle, from the largest mesh and the smallest; NaN of one mesh."""
    held = {int(r["triangles"]): float(r["memory"]) for r in rows}
    if len(held) < 2:
        return float(np.nan)
    least, most = min(held), max(held)
    return (held[most] - held[least]) / (most - least)
