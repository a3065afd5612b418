"""Checks that the benchmark's errors are what they must be.

For each scene and component, against the repository's reference or an own long one:

    slope   budgets N of so many seeds that all budgets see the same number of samples: N times the
            mean square error must be the same number for each, the variance of a sample
    size    the mean square error must be the mean of the variances that the images themselves state
    spread  the same for samples that went where the noise is, and their mean error must be none

Each by z-test, Šidák-corrected for all of them; standard errors from the scatter of blocks of
pixels.  Then the images are falsified, and every falsification must be noticed in half of the
scenes at least: rare bright paths hide it in the others.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from benchmark_error import FIRST_SEED, Plan, reference
from benchmark_runs import alone
from benchmark_stats import COMPONENTS, Reference, mean_square, vanishes
from common import SCENES, Array, Image, Report, blocks, read, sidak_z

# samples a pixel that every budget sees, and the budgets
SEEN, BUDGETS = 128, [8, 32, 128]
SIGNIFICANCE = 1e-3
# images whose samples are spread, of the largest budget
SPREAD, SPREAD_IMAGES = 0, 4
# others fall faster
SAMPLER = ["--sampler", "independent"]
# pixels along an edge of the blocks that are taken as independent
BLOCK = 8
Images = dict[int, list[Image]]
Falsify = Callable[[int, Image], Image]


def rendered(name: str) -> Images:
    """Render all budgets."""
    images: Images = {}
    with tempfile.TemporaryDirectory() as folder:
        for budget in BUDGETS:
            for i in range(SEEN // budget):
                seed = FIRST_SEED + 1000 * budget + i
                options = ["--spp", str(budget), "--seed", str(seed), *SAMPLER]
                alone(SCENES / name / "scene.xml", Path(folder), *options)
                images.setdefault(budget, []).append(read(Path(folder) / "image.exr"))
        for i in range(SPREAD_IMAGES):
            options = ["--spp", str(BUDGETS[-1]), "--seed", str(FIRST_SEED + i), *SAMPLER]
            alone(SCENES / name / "scene.xml", Path(folder), "--adaptive", *options)
            images.setdefault(SPREAD, []).append(read(Path(folder) / "image.exr"))
    return images


def z_of(values: Array) -> Array:
    """Return the mean of [H,W,4] by component over its standard error between blocks."""
    sums = blocks(values, BLOCK).reshape(-1, COMPONENTS)
    error = sums.std(0, ddof=1) / np.sqrt(len(sums))
    return np.divide(sums.mean(0), error, out=np.zeros(COMPONENTS), where=error > 0)


def judge(name: str, images: Images, known: Reference, report: Report, tests: int) -> None:
    """Note the z of slopes and sizes."""
    limit = sidak_z(SIGNIFICANCE, tests)
    of_sample: dict[int, Array] = {}
    for budget, runs in ((n, images[n]) for n in BUDGETS):
        square = [(run.mean[..., 0] - known.mean) ** 2 - known.variance for run in runs]
        of_sample[budget] = budget * np.mean(square, axis=0)
    stated = {n: n * np.mean([r.variance[..., 0] for r in images[n]], 0) for n in BUDGETS}
    most = BUDGETS[-1]
    slopes = [z_of(of_sample[n] - of_sample[most]) for n in BUDGETS[:-1]]
    sizes = [z_of(of_sample[n] - stated[n]) for n in BUDGETS]
    errors = [run.mean[..., 0] - known.mean for run in images[SPREAD]]
    square = np.mean([e**2 - known.variance for e in errors], 0)
    variance = np.mean([run.variance[..., 0] for run in images[SPREAD]], 0)
    spread = [z_of(square - variance), z_of(np.mean(errors, 0))]
    error = mean_square(images[most][0].mean[..., 0], known)
    for k in range(COMPONENTS):
        if vanishes(abs(error[k]), known.level()):
            continue
        for what, z in (("slope", slopes), ("size", sizes), ("spread", spread)):
            worst = max(abs(float(row[k])) for row in z)
            report.within(f"{name}: S{k}, largest |z| of the {what}", worst, limit)


def scaled(image: Image, factor: float) -> Image:
    """Return an image with other values and the same noise stated."""
    return Image(image.mean * factor, image.variance)


FALSIFIED: dict[str, Falsify] = {
    "5 % brighter": lambda _, image: scaled(image, 1.05),
    "noise of twice the variance stated": lambda _, image: Image(image.mean, image.variance / 2),
    "a tenth of the light of noisy pixels is lost where samples are spread": lambda n, image: (
        Image(dimmed(image), image.variance) if n == SPREAD else image
    ),
    "the largest budget has stopped half way": lambda n, image: (
        Image(noisier(image), image.variance * 2) if n == BUDGETS[-1] else image
    ),
}


def dimmed(image: Image) -> Array:
    """Return the mean without a tenth of the light of the noisier half of the pixels."""
    noise = image.variance[:, :, 0, 0]
    lost = np.where(noise > np.median(noise), 0.1, 0.0)
    return image.mean * (1 - lost)[:, :, None, None]


def noisier(image: Image) -> Array:
    """Return the mean with noise as large as its own on top."""
    random = np.random.default_rng(1)
    return image.mean + np.sqrt(image.variance) * random.standard_normal(image.mean.shape)


def check(scenes: list[str]) -> int:
    """Render, judge, falsify; return the exit status."""
    tests = len(scenes) * COMPONENTS * (2 * len(BUDGETS) + 1)
    plan = Plan(scenes, BUDGETS, 1)
    report = Report("Errors of the benchmark")
    everything = {}
    for name in scenes:
        everything[name] = rendered(name), reference(name, "mono", plan)
        judge(name, *everything[name], report, tests)
    bad = report.finish()
    print("falsified")
    for what, falsify in FALSIFIED.items():
        noticed = []
        for name, (images, known) in everything.items():
            changed = {n: [falsify(n, image) for image in runs] for n, runs in images.items()}
            trial = Report(what)
            judge(name, changed, known, trial, tests)
            noticed += [name] * any(not good for *_, good in trial.rows)
        enough = 2 * len(noticed) >= len(scenes)
        print(f"{what}: in {', '.join(noticed) or 'none'}: {'ok' if enough else 'NOT NOTICED'}")
        bad += not enough
    return int(bad > 0)
