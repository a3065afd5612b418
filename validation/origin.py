"""What a table of measurements is from: the version of the sources, the time and the machine."""

import datetime
import os
import platform
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


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


def _git(*words: str) -> str | None:
    """Return what git says, nothing where there is no git or it fails."""
    try:
        told = subprocess.run(["git", *words], cwd=ROOT, text=True, capture_output=True)
    except OSError:
        return None
    return told.stdout.strip() if told.returncode == 0 else None


def commit() -> str:
    """Return the commit of the working tree, marked if anything but pages has changed since."""
    found = _git("describe", "--always")
    if not found:
        return "no commit"
    changed = _git("status", "--porcelain", "--untracked-files=no", "--", ".", ":!docs", ":!*.md")
    return f"commit {found}" + "-dirty" * bool(changed)


def made(program: str) -> str:
    """Return what follows a command: program and commit, time, machine, load."""
    now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC")
    load = f"{os.getloadavg()[0]:.1f}"
    return f"{program}, {commit()}; {now}; {machine()}; load average {load}"
