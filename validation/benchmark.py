#!/usr/bin/env python3
"""Run time against error, beside Mitsuba where its wheel is: measures, draws, writes the report.

    validation/.venv/bin/python validation/benchmark.py --python ~/mitsuba/bin/python
    validation/.venv/bin/python validation/benchmark.py threads lamps
    validation/.venv/bin/python validation/benchmark.py --quick

Parts: error (with --scenes, --budgets, --film), polarization, threads, triangles, lamps,
wavelengths.  If no --scenes are named, error takes six and a coloured one, polarization all that
are bundled, threads and --quick the six.  Each part writes its CSV files to docs/benchmark (or
-o DIR/benchmark), and every call composes docs/benchmark.md of all that are there; `report` only
composes.  --quick measures little, writes nothing, and checks that errors fall as they must and
have the size that variances say.
Measure on a quiet machine: ratios come from turns taken and hold on a busy one too, times do not.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import benchmark_error
import benchmark_quick
import benchmark_scaling
import benchmark_tables as tables
import mitsuba_peer
import origin
from benchmark_compose import compose
from benchmark_scenes import COLOURED, SIX
from common import ROOT, SCENES, arguments, binary, give_up, skip

PARTS = ["error", "polarization", "threads", "triangles", "lamps", "wavelengths"]
BUDGETS = "1,4,16,64,256"


def parser() -> argparse.ArgumentParser:
    """Return the command line."""
    words = arguments(__doc__)
    words.add_argument("parts", nargs="*", metavar="PART", help="(default: all of them)")
    words.add_argument("--scenes", help="names with commas (default: those of each part)")
    words.add_argument("--budgets", default=BUDGETS, help=f"samples a pixel ({BUDGETS})")
    words.add_argument("--film", metavar="WxH", help="size for errors (default: each scene's)")
    words.add_argument("--turns", type=int, default=5, help="repetitions (default 5)")
    words.add_argument("--reference-spp", type=int, default=4096, help="of own references")
    words.add_argument("--largest", type=int, default=2_000_000, help="most triangles")
    words.add_argument("-o", metavar="DIR", type=Path, default=ROOT / "docs")
    words.add_argument("--quick", action="store_true", help="check the machinery")
    mitsuba_peer.add_arguments(words)
    return words


def checked(words: argparse.ArgumentParser) -> argparse.Namespace:
    """Return the arguments, or say what is wrong with them."""
    args = words.parse_args()
    if unknown := set(args.parts) - {*PARTS, "report"}:
        words.error(f"unknown part {', '.join(sorted(unknown))}, expected {', '.join(PARTS)}")
    try:
        args.budgets = sorted({int(n) for n in args.budgets.split(",")})
    except ValueError:
        words.error(f"--budgets: expected numbers with commas, found '{args.budgets}'")
    if args.budgets[0] < 1 or args.turns < 1:
        words.error("budgets and turns must be at least 1")
    args.scenes = args.scenes.split(",") if args.scenes else []
    known = bundled()
    if unknown := set(args.scenes) - set(known):
        words.error(f"no scene {', '.join(sorted(unknown))}, expected of {', '.join(known)}")
    return args


def bundled() -> list[str]:
    """Return the names of all scenes of the repository."""
    return sorted(path.parent.name for path in SCENES.glob("*/scene.xml"))


def scenes_of(part: str, args: argparse.Namespace) -> list[str]:
    """Return the scenes that a part renders."""
    usual = {"error": [*SIX, *COLOURED], "polarization": bundled()}
    return args.scenes or usual.get(part, SIX)


def made_by(part: str) -> str:
    """Return what goes on top of a CSV: command, version, time, machine, load."""
    words = list(sys.argv[1:])
    # places of this machine say nothing elsewhere
    for i, word in enumerate(words[:-1]):
        if word in ("--python", "-o"):
            words[i + 1] = {"--python": "PYTHON", "-o": "DIR"}[word]
    command = f"validation/benchmark.py {' '.join(words)}".strip()
    version = subprocess.run([binary(), "--version"], text=True, stdout=subprocess.PIPE).stdout
    return f"{command} ({part}); {origin.made(version.strip())}"


def measure(part: str, args: argparse.Namespace, folder: Path, peer: str | None) -> None:
    """Measure one part and write its files."""
    made = made_by(part)
    scenes = scenes_of(part, args)
    if part == "error":
        plan = benchmark_error.Plan(
            scenes, args.budgets, args.turns, args.film, args.reference_spp, peer
        )
        found = benchmark_error.measure(plan)
        notes = [f"; {note}" for note in found.notes]
        files = {
            "error": found.error,
            "scatter": found.scatter,
            "rates": found.rates,
            "start": found.start,
        }
        made += "".join(notes)
    elif part == "polarization":
        files = {part: benchmark_scaling.polarization(scenes, args.turns)}
    elif part == "threads":
        files = {part: benchmark_scaling.threads(scenes, args.turns)}
    elif part == "triangles":
        files = {part: benchmark_scaling.triangles(args.turns, args.largest)}
    elif part == "lamps":
        files = {part: benchmark_scaling.lamps(args.turns)}
    else:
        files = {part: benchmark_scaling.wavelengths(args.turns)}
    for name, rows in files.items():
        if rows:
            tables.write(folder / f"{name}.csv", made, rows)
        else:
            (folder / f"{name}.csv").unlink(missing_ok=True)


def main() -> int:
    """Measure what is asked for, and compose the report."""
    args = checked(parser())
    parts = ["quick"] if args.quick else args.parts or PARTS
    rendered = {scene for part in parts if part != "report" for scene in scenes_of(part, args)}
    if "big_mesh" in rendered:
        made = subprocess.run([sys.executable, str(SCENES / "make_meshes.py")], check=False)
        if made.returncode != 0:
            give_up("scenes/make_meshes.py could not write the mesh of big_mesh")
    if args.quick:
        return benchmark_quick.check(scenes_of("quick", args))
    beside = "error" in parts and mitsuba_peer.installed(args.python)
    if "error" in parts and not beside:
        if args.require:
            return skip(mitsuba_peer.MISSING, required=True)
        print(f"without Mitsuba: {mitsuba_peer.MISSING}")
    folder = args.o / "benchmark"
    for part in parts:
        if part != "report":
            print(f"--- {part}", flush=True)
            measure(part, args, folder, args.python if beside else None)
    report = args.o / "benchmark.md"
    report.write_text(compose(folder), encoding="utf-8")
    print(f"wrote {report}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
