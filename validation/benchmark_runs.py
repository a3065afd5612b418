"""Runs of Brewster for the benchmark: with what the system counted, alone or side by side."""

import json
import os
import platform
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from common import binary, give_up

KIB = 1024


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
    runs = []
    for process in started:
        assert process.stdout is not None
        text = process.stdout.read()
        # wait4 alone says how much memory this one process held
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            give_up(f"failed with status {process.returncode}: {' '.join(command)}")
        runs.append(Run(json.loads(text), usage.ru_maxrss * KIB))
    return runs


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


def machine() -> str:
    """Return the processor, its cores and the memory in one line."""
    model = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        lines = information.read_text().splitlines()
        names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
        family = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model\t")]
        model = names[0] if names else model
        model += f" (model {family[0]})" if family else ""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return f"{model}, {os.cpu_count()} cores, {memory:.0f} GiB, {platform.system()}"
