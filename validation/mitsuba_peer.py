"""Finds a Python that has Mitsuba, and runs `mitsuba_render.py` in it."""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

SCRIPT = Path(__file__).parent / "mitsuba_render.py"
MISSING = "mitsuba not installed (pip install mitsuba==3.9.1, or --python PATH)"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose the peer."""
    parser.add_argument(
        "--python", default=sys.executable, help="a Python that has Mitsuba's wheel"
    )
    parser.add_argument("--require", action="store_true", help="exit 2 where Mitsuba is missing")


def installed(python: str) -> bool:
    """Return whether this Python can import Mitsuba."""
    found = subprocess.run([python, "-c", "import mitsuba"], stderr=subprocess.DEVNULL)
    return found.returncode == 0


def run(
    python: str,
    scene: Path,
    *options: str,
    script: Path = SCRIPT,
    environment: dict[str, str] | None = None,
) -> dict[str, Any]:
    """Render with Mitsuba and return what the script printed."""
    command = [python, str(script), str(scene), *options]
    done = subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE, env=environment)
    out = done.stdout
    return json.loads(out.splitlines()[-1])
