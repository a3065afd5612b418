"""Measures error against CPU time over a ladder of budgets, ours and Mitsuba's taking turns.

A mode is one wavelength (`mono`) or all of them (`spectral`: `--rgb` here, its luminance over that
of the unit spectrum, and llvm_ad_spectral_polarized there).  Coloured scenes have the second alone:
Mitsuba's mono variants make one number of a spectrum, ours takes it at one wavelength.  A program
is Brewster, Brewster with its samples where the noise is (`--adaptive`), or Mitsuba.  One turn
renders every budget once in each mode and program, with seeds of its own, and a pass of PASS
samples at SIZE for the paths per core-second.  Errors are those of the film's own size, where the
repository holds references; of other sizes and scenes the reference is a long rendering of
Brewster's, kept in target/benchmark.
"""

import hashlib
import os
import shutil
import site
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mitsuba_peer
import numpy as np
from benchmark_runs import Run, alone
from benchmark_scenes import COLOURED
from benchmark_stats import COMPONENTS, Reference, mean_square, scatter
from common import REFERENCES, ROOT, SCENES, Array, read
from mitsuba_figures import LUMINANCE, UNIT_LUMINANCE

SIZE = "256x256"
PASS = 16
MODES = {"mono": [], "spectral": ["--rgb"]}
OURS = {"brewster": [], "adaptive": ["--adaptive"]}
# fewer samples than this are too few to be spread
FEWEST_SPREAD = 16
CACHE = ROOT / "target" / "benchmark"
SCRIPT = Path(__file__).parent / "benchmark_mitsuba.py"
# seeds of turns stay clear of those of the references
FIRST_SEED, PEER_SEED, REFERENCE_SEED = 10_000, 20_000, 999_983

Row = dict[str, Any]


@dataclass
class Plan:
    """What to measure."""

    scenes: list[str]
    budgets: list[int]
    turns: int
    film: str | None = None
    reference_spp: int = 4096
    # a Python with Mitsuba, or none
    peer: str | None = None


@dataclass
class Measured:
    """Rows of the four tables, and what could not be measured."""

    error: list[Row] = field(default_factory=list)
    scatter: list[Row] = field(default_factory=list)
    rates: list[Row] = field(default_factory=list)
    start: list[Row] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def modes_of(name: str) -> list[str]:
    """Return the modes in which a scene means the same in both programs."""
    return [mode for mode in MODES if mode != "mono" or name not in COLOURED]


def stokes(path: Path) -> Array:
    """Return S of an image of either mode, [H,W,4]; of colours the luminance."""
    mean = read(path).mean
    return mean[..., 0] if mean.shape[-1] == 1 else mean @ LUMINANCE / UNIT_LUMINANCE


def sized(film: str | None) -> list[str]:
    """Return the options for this size of the film."""
    return ["--size", film] if film else []


def reference(name: str, mode: str, plan: Plan) -> Reference:
    """Return the repository's reference, or render one, or take that of an earlier time."""
    stored = REFERENCES / f"{name}.npz"
    if plan.film is None and stored.exists():
        with np.load(stored) as file:
            mean, error = file["S"].astype(float), file["stderr"].astype(float)
        # of plain numbers, which have no colour
        if mean.ndim == 3:
            return Reference(mean, error**2, f"`references/{name}.npz`")
    # the scatter of halves knows the variance of a luminance, colours do not
    halves = [long_rendering(name, mode, plan, half) for half in (0, 1)]
    mean = (halves[0] + halves[1]) / 2
    return Reference(mean, (halves[0] - halves[1]) ** 2 / 4, f"own, {plan.reference_spp} samples")


def long_rendering(name: str, mode: str, plan: Plan, half: int) -> Array:
    """Return half of the samples of an own reference."""
    scene = SCENES / name / "scene.xml"
    spp = max(plan.reference_spp // 2, 1)
    key = hashlib.sha256(scene.read_bytes()).hexdigest()[:12]
    kept = CACHE / f"{name}-{mode}-{plan.film or 'film'}-{spp}-{half}-{key}.exr"
    if not kept.exists():
        CACHE.mkdir(parents=True, exist_ok=True)
        options = [*MODES[mode], *sized(plan.film), "--spp", str(spp)]
        with tempfile.TemporaryDirectory() as folder:
            seed = str(REFERENCE_SEED + half)
            alone(scene, Path(folder), *options, "--seed", seed)
            shutil.copyfile(Path(folder) / "image.exr", kept)
    return stokes(kept)


def ours(
    name: str, mode: str, program: str, turn: int, plan: Plan
) -> Iterator[tuple[int, Array, Run]]:
    """Render every budget of a turn."""
    for i, spp in enumerate(plan.budgets):
        if program == "adaptive" and spp < FEWEST_SPREAD:
            continue
        seed = FIRST_SEED + 100 * turn + i
        options = [*MODES[mode], *OURS[program], *sized(plan.film)]
        options += ["--spp", str(spp), "--seed", str(seed)]
        with tempfile.TemporaryDirectory() as folder:
            run = alone(SCENES / name / "scene.xml", Path(folder), *options)
            yield spp, stokes(Path(folder) / "image.exr"), run


def theirs(
    name: str, mode: str, turn: int, plan: Plan, home: Path
) -> tuple[dict[str, Array], dict[str, Any]]:
    """Render every budget of a turn in Mitsuba; its kernels are kept in `home`."""
    assert plan.peer is not None
    # a home of its own starts without compiled kernels, but must not hide installed packages
    base = os.environ.get("PYTHONUSERBASE", site.getuserbase())
    environment = {**os.environ, "HOME": str(home), "PYTHONUSERBASE": base}
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "images.npz"
        options = ["--variant", f"llvm_ad_{mode}_polarized", "--out", str(out)]
        options += ["--budgets", ",".join(map(str, plan.budgets)), "--size", SIZE]
        options += ["--pass", str(PASS), "--seed", str(PEER_SEED + 10 * turn)]
        options += ["--film", plan.film] if plan.film else []
        scene = SCENES / name / "scene.xml"
        told = mitsuba_peer.run(plan.peer, scene, *options, script=SCRIPT, environment=environment)
        with np.load(out) as file:
            return {budget: file[budget].astype(float) for budget in file}, told


class Scene:
    """One scene in the making: its references, and the images of the largest budget so far."""

    def __init__(self, name: str, plan: Plan, to: Measured) -> None:
        """Find the references."""
        self.name, self.plan, self.to = name, plan, to
        self.references = {mode: reference(name, mode, plan) for mode in modes_of(name)}
        self.largest: dict[tuple[str, str], list[Array]] = {}

    def note(
        self, program: str, mode: str, turn: int, spp: int, image: Array, **spent: float | str
    ) -> None:
        """Add the row of one image."""
        known = self.references[mode]
        square, noise = mean_square(image, known), known.noise()
        row = {"scene": self.name, "mode": mode, "program": program, "turn": turn, "spp": spp}
        row |= {"paths": image.shape[0] * image.shape[1] * spp, **spent, "level": known.level()}
        row |= {f"square{k}": square[k] for k in range(COMPONENTS)}
        row |= {f"noise{k}": noise[k] for k in range(COMPONENTS)}
        self.to.error.append({**row, "reference": known.origin})
        if spp == max(self.plan.budgets):
            self.largest.setdefault((mode, program), []).append(image)

    def our_turn(self, mode: str, turn: int) -> None:
        """Render the ladders and the timed passes."""
        rendered = [
            (program, *one)
            for program in OURS
            for one in ours(self.name, mode, program, turn, self.plan)
        ]
        for program, spp, image, run in rendered:
            self.note(program, mode, turn, spp, image, rays=run.told["rays"], cpu_s=run.cpu())
            if program == "brewster" and spp == min(self.plan.budgets):
                wall, cpu = run.start()
                row = {"scene": self.name, "program": "brewster", "mode": mode, "turn": turn}
                self.to.start.append({**row, "what": "load", "wall_s": wall, "cpu_s": cpu})
        with tempfile.TemporaryDirectory() as folder:
            timed = [*MODES[mode], "--size", SIZE, "--spp", str(PASS)]
            run = alone(SCENES / self.name / "scene.xml", Path(folder), *timed)
        row = {"scene": self.name, "program": "brewster", "mode": mode, "turn": turn}
        row |= {"paths": run.told["paths"], "rays": run.told["rays"], "cpu_s": run.cpu()}
        self.to.rates.append(row)

    def peer_turn(self, mode: str, turn: int, home: Path) -> None:
        """Let Mitsuba do the same."""
        try:
            images, told = theirs(self.name, mode, turn, self.plan, home)
        except subprocess.CalledProcessError:
            self.to.notes.append(f"Mitsuba does not render `{self.name}` ({mode})")
            return
        for (spp, image), cpu in zip(images.items(), told["cpu_s"], strict=True):
            self.note("mitsuba", mode, turn, int(spp), image, rays="", cpu_s=cpu)
        row = {"scene": self.name, "program": "mitsuba", "mode": mode, "turn": turn}
        paths, cpu = told["pass"]["paths"], told["pass"]["cpu_s"]
        self.to.rates.append({**row, "paths": paths, "rays": "", "cpu_s": cpu})
        for what in ("load", "compile"):
            wall, cpu = told[what]
            row = {"scene": self.name, "program": "mitsuba", "mode": mode, "turn": turn}
            self.to.start.append({**row, "what": what, "wall_s": wall, "cpu_s": cpu})

    def finish(self) -> None:
        """Add the scatter between the turns."""
        for (mode, program), images in self.largest.items():
            if len(images) < 2:
                continue
            between = scatter(images)
            row = {"scene": self.name, "mode": mode, "program": program}
            row |= {"spp": max(self.plan.budgets), "level": self.references[mode].level()}
            row |= {f"scatter{k}": between[k] for k in range(COMPONENTS)}
            self.to.scatter.append(row)


def measure(plan: Plan) -> Measured:
    """Measure every scene, the programs and modes taking turns, in the other order every time."""
    to = Measured()
    with tempfile.TemporaryDirectory() as home:
        for name in plan.scenes:
            scene = Scene(name, plan, to)
            for turn in range(plan.turns):
                print(f"{name}: turn {turn + 1} of {plan.turns}", flush=True)
                order = [(mode, peer) for mode in modes_of(name) for peer in (False, True)]
                for mode, peer in order[:: -1 if turn % 2 else 1]:
                    if not peer:
                        scene.our_turn(mode, turn)
                    elif plan.peer:
                        scene.peer_turn(mode, turn, Path(home))
            scene.finish()
    to.notes = sorted(set(to.notes))
    return to
