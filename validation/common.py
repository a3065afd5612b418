"""What the checks share: running Brewster, reading its images, statistics and tables."""

import argparse
import functools
import json
import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import OpenEXR
from numpy.typing import ArrayLike, NDArray
from scipy import stats

ROOT = Path(__file__).resolve().parent.parent
SCENES = ROOT / "scenes"
REFERENCES = ROOT / "validation" / "references"

Array = NDArray[np.float64]

# Relative round-off of 32-bit images and ray geometry.
ROUND_OFF = 2e-6


# ---------------------------------------------------------------- Brewster


@functools.cache
def binary() -> str:
    """Return the program's path: `$BREWSTER`, or a release build of this workspace."""
    if ready := os.environ.get("BREWSTER"):
        return ready
    build = ["cargo", "build", "--release", "--bin", "brewster", "--message-format=json"]
    out = subprocess.run(build, cwd=ROOT, check=True, text=True, stdout=subprocess.PIPE).stdout
    messages = [json.loads(line) for line in out.splitlines()]
    return next(m["executable"] for m in messages if m.get("executable"))


# for statements on single pixels: the variance of a few blocks of Sobol' points is told too roughly
INDEPENDENT = ("--sampler", "independent")


def render(scene: Path, out: Path, *options: str, program: str | None = None) -> dict[str, Any]:
    """Render `scene` to `out`, with `program` or `binary()`, and return what `--json` reports."""
    command = [
        program or binary(),
        "render",
        str(scene),
        "-o",
        str(out),
        "--quiet",
        "--json",
        *options,
    ]
    run = subprocess.run(command, text=True, stdout=subprocess.PIPE)
    if run.returncode != 0:
        give_up(f"failed with status {run.returncode}: {' '.join(command)}")
    return json.loads(run.stdout)


@dataclass
class Image:
    """Stokes image: `mean` and `variance` of that mean, both [H,W,4,C]."""

    mean: Array
    variance: Array


def _components(channels: dict[str, Array], suffix: str) -> Array:
    """Stack `S0{suffix}` … `S3{suffix}`, or their R, G and B, to [H,W,4,C]."""
    colours = [".R", ".G", ".B"] if f"S0{suffix}.R" in channels else [""]
    rows = [np.stack([channels[f"S{k}{suffix}{c}"] for c in colours], -1) for k in range(4)]
    return np.stack(rows, 2)


def read(path: Path) -> Image:
    """Read an EXR that Brewster wrote for one wavelength or with `--rgb`."""
    with OpenEXR.File(str(path), separate_channels=True) as exr:
        channels = {n: np.asarray(c.pixels, np.float64) for n, c in exr.channels().items()}
    mean = _components(channels, "")
    # a single sample has no variance
    several = any(name.startswith("S0.var") for name in channels)
    return Image(mean, _components(channels, ".var") if several else np.full_like(mean, np.nan))


# -------------------------------------------------------------- statistics


def sidak_z(significance: float, tests: int) -> float:
    """Return the |z| that `tests` independent normal numbers all stay below, but for
    a chance of `significance` (Šidák)."""
    return float(stats.norm.isf(-np.expm1(np.log1p(-significance) / tests) / 2))


def blocks(x: Array, size: int) -> Array:
    """Sum [H,W,…] over blocks of size × size pixels; a rest at the border is left out."""
    h, w = x.shape[0] // size, x.shape[1] // size
    x = x[: h * size, : w * size]
    return x.reshape(h, size, w, size, *x.shape[2:]).sum((1, 3))


@dataclass
class Report:
    """Collects verdicts, prints them as a table, and knows the exit status."""

    title: str
    rows: list[tuple[str, float, float, bool]] = field(default_factory=list)

    def within(self, what: str, value: float, limit: float) -> None:
        """Note that `value` must not exceed `limit` (NaN always does)."""
        self.rows.append((what, value, limit, bool(value <= limit)))

    def same_image(
        self,
        what: str,
        image: Image,
        expected: Array,
        *,
        block: int,
        significance: float = 1e-3,
        systematic: ArrayLike = 0.0,
        least_variance: ArrayLike = 0.0,
    ) -> None:
        """Test each Stokes component by z over blocks, Šidák-corrected for all of them.

        `systematic` is an absolute error, per pixel, of `expected` itself; round-off of
        32-bit images is always allowed.  `least_variance`, per pixel and known beforehand,
        stands in where too few samples saw something to estimate it.
        """
        shape = image.mean.shape
        n = block * block
        d = blocks(image.mean - expected, block) / n
        scale = np.abs(expected[:, :, :1]).mean()
        allowed = np.broadcast_to(systematic, shape) + ROUND_OFF * (scale + np.abs(expected))
        least = blocks(np.broadcast_to(least_variance, shape), block)
        sigma = np.sqrt(np.maximum(blocks(image.variance, block), least)) / n
        excess = np.maximum(np.abs(d) - blocks(allowed, block) / n, 0)
        # without noise nothing but the allowance may remain
        z = np.divide(excess, sigma, out=np.where(excess > 0, np.inf, 0.0), where=sigma > 0)
        limit = sidak_z(significance, z.size)
        for k in range(4):
            self.within(f"{what}: S{k}, largest |z| of a block", float(z[:, :, k].max()), limit)

    def finish(self) -> int:
        """Print the table; return 0 if all is well and 1 otherwise."""
        print(f"{self.title}\n")
        width = max(len(what) for what, *_ in self.rows)
        print(f"{'':{width}}  {'value':>11} {'limit':>11}")
        for what, value, limit, good in self.rows:
            print(f"{what:{width}}  {value:11.4g} {limit:11.4g}  {'ok' if good else 'DIFFERS'}")
        bad = sum(not good for *_, good in self.rows)
        print(f"\n{len(self.rows) - bad} agree, {bad} differ\n")
        return int(bad > 0)


def arguments(description: str | None) -> argparse.ArgumentParser:
    """Return a parser whose help is the script's own first words."""
    return argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )


def give_up(reason: str) -> NoReturn:
    """Say why nothing can be checked, and leave with status 2."""
    print(reason, file=sys.stderr)
    sys.exit(2)


def skip(reason: str, *, required: bool) -> int:
    """Say why nothing was checked; 2 where the check was asked for, 0 otherwise."""
    print(f"skipped: {reason}", file=sys.stderr if required else sys.stdout)
    return 2 if required else 0
