"""Runs of Brewster for the benchmark: with what the system counted, alone or side by side."""

import json
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from common import binary, give_up

KIB = 1024
# seconds between looks at a process's memory
POLL = 0.02


@dataclass
class Run:
    """What `--json` reports of a render, and the most memory that it held, bytes."""

    told: dict[str, Any]
    memory: int

    def cpu(self) -> float:
        """Return CPU seconds of sampling, all threads."""
        return float(self.told["sampling_cpu_s"])

    def per_core_second(self, what: str = "paths") -> float:
        """Return paths (or rays) per CPU second of sampling."""
        return float(self.told[what]) / self.cpu()

    def per_second(self) -> float:
        """Return paths per second of the clock while sampling."""
        return float(self.told["paths"]) / float(self.told["sampling_wall_s"])

    def start(self) -> tuple[float, float]:
        """Return what is not sampling (loading, building, writing): seconds, CPU seconds."""
        wall = float(self.told["wall_s"]) - float(self.told["sampling_wall_s"])
        return wall, float(self.told["total_cpu_s"]) - self.cpu()


def run_at_once(scene: Path, each: list[list[str]]) -> list[Run]:
    """Render in as many processes at once as there are lists of options."""
    command = [binary(), "render", str(scene), "--quiet", "--json"]
    started = [
        subprocess.Popen([*command, *options], text=True, stdout=subprocess.PIPE)
        for options in each
    ]
    memory = dict.fromkeys(range(len(started)), 0)
    while any(process.poll() is None for process in started):
        for i, process in enumerate(started):
            memory[i] = max(memory[i], held(process.pid))
        time.sleep(POLL)
    runs = []
    for i, process in enumerate(started):
        text, _ = process.communicate()
        if process.returncode != 0:
            give_up(f"failed with status {process.returncode}: {' '.join(command)}")
        runs.append(Run(json.loads(text), memory[i]))
    return runs


def held(pid: int) -> int:
    """Return the most memory that a process has held so far, bytes; 0 where no one says.

    What wait4 says counts the parent's memory too, up to the moment the program is loaded.
    """
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0
    lines = [line for line in status.splitlines() if line.startswith("VmHWM:")]
    return int(lines[0].split()[1]) * KIB if lines else 0


def alone(scene: Path, folder: Path, *options: str) -> Run:
    """Render in one process; the image is image.exr in the folder."""
    return run_at_once(scene, [[*options, "-o", str(folder / "image.exr")]])[0]


def side_by_side(count: int, scene: Path, folder: Path, *options: str) -> list[Run]:
    """Render with seeds of their own in `count` processes at once."""
    return run_at_once(
        scene,
        [
            [*options, "--seed", str(seed), "-o", str(folder / f"{seed}.exr")]
            for seed in range(1, count + 1)
        ],
    )
