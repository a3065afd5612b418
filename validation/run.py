#!/usr/bin/env python3
"""Runs every check that needs no Mitsuba, in a virtual environment of its own.

    python3 validation/run.py [--full] [CHECK …]

Needs Python 3.11 with `venv`, the Rust toolchain and the Python package registry; the rest is
installed into validation/.venv.  Exit status: 0 all agree, 1 something differs, 2 cannot run.
"""

import argparse
import hashlib
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import NoReturn

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
VENV = HERE / ".venv"
REQUIREMENTS = HERE / "requirements.txt"
PYTHON = VENV / "bin" / "python"

RUFF = [str(VENV / "bin" / "ruff")]
LINTED = ["validation", "scenes"]
CHECKS = {
    "format": [*RUFF, "format", "--check", *LINTED],
    "lint": [*RUFF, "check", *LINTED],
    "covariant": [str(PYTHON), "validation/covariant.py"],
    "interfaces": [str(PYTHON), "validation/interfaces.py"],
    "colour_path": [str(PYTHON), "validation/colour_path.py"],
    "fresnel_sphere": [str(PYTHON), "validation/fresnel_sphere.py"],
    "plates": [str(PYTHON), "validation/plates.py"],
    "films": [str(PYTHON), "validation/films.py"],
    "polarization_camera": [str(PYTHON), "validation/polarization_camera.py"],
    "fields": [str(PYTHON), "validation/fields.py", "--self-test"],
    "light": [str(PYTHON), "validation/light.py", "--self-test"],
    "scattering": [str(PYTHON), "validation/scattering.py", "--self-test"],
    "surfaces": [str(PYTHON), "validation/surfaces.py", "--self-test"],
    "stability": [str(PYTHON), "validation/stability.py", "--self-test"],
    "stress_images": [str(PYTHON), "validation/stress_images.py"],
    "references": [str(PYTHON), "validation/references.py"],
    "benchmark": [str(PYTHON), "validation/benchmark.py", "--quick"],
}
# those with more to do when there is time
WITH_FULL = {"stability", "references"}


def give_up(reason: str) -> NoReturn:
    """Say why nothing can be checked, and leave with status 2."""
    print(f"validation: {reason}", file=sys.stderr)
    sys.exit(2)


def prepare() -> None:
    """Make the environment, or bring it up to the pinned versions."""
    wanted = hashlib.sha256(REQUIREMENTS.read_bytes()).hexdigest()
    stamp = VENV / "requirements.sha256"
    if stamp.exists() and stamp.read_text() == wanted:
        return
    if sys.version_info < (3, 11):  # noqa: UP036
        give_up(f"Python 3.11 or newer is needed, this is {sys.version.split()[0]}")
    try:
        import ensurepip  # noqa: F401
        import venv
    except ImportError:
        give_up("Python has no venv here; on Debian: apt-get install python3-venv")
    print("validation: installing the pinned requirements", flush=True)
    venv.create(VENV, with_pip=True, clear=True)
    pip = [str(PYTHON), "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    if subprocess.run([*pip, "-r", str(REQUIREMENTS)]).returncode != 0:
        give_up("the requirements could not be installed")
    stamp.write_text(wanted)


def main() -> int:
    """Run the checks one after the other and print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("checks", nargs="*", metavar="CHECK", help=f"of {', '.join(CHECKS)}")
    parser.add_argument(
        "--full", action="store_true", help="references at full size, denser sweeps"
    )
    args = parser.parse_args()
    if unknown := set(args.checks) - set(CHECKS):
        parser.error(f"unknown check {', '.join(sorted(unknown))}, expected {', '.join(CHECKS)}")
    prepare()
    # colour-science warns that it could draw if it had a plotting library; py_pol brings one
    environment = {
        **os.environ,
        "PYTHONWARNINGS": 'ignore:"Matplotlib" related',
        "MPLBACKEND": "agg",
    }
    rows = []
    for name in args.checks or CHECKS:
        print(f"=== {name}", flush=True)
        start = time.monotonic()
        full = ["--full"] if args.full and name in WITH_FULL else []
        status = subprocess.run([*CHECKS[name], *full], cwd=ROOT, env=environment).returncode
        rows.append((name, time.monotonic() - start, status))
    print("\nvalidation\n")
    for name, seconds, status in rows:
        print(f"{name:20} {seconds:6.1f} s  {'passed' if status == 0 else f'FAILED ({status})'}")
    failed = sum(status != 0 for *_, status in rows)
    print(f"\n{len(rows) - failed} passed, {failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
