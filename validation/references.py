"""The eight scenes against their reference images, every Stokes component.

Renders each scene with several seeds and lets `brewster compare` judge mean and noise:

    --max-block-frac 0.01 --max-bias-t 5 --max-z-frac 0.01 --max-rmse LIMIT

`--full` takes 4 seeds of 128 samples and allows 1.5 times the peer's own RMSE plus 2e-4.  At
fewer samples N in all the noise part of that RMSE grows: with σ_ref the reference's standard error,

    LIMIT = 1.5 √(σ_ref² + (peer² − σ_ref²) 512/N) + 2e-4.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from common import REFERENCES, SCENES, arguments, binary, give_up, render

PEER_SAMPLES = 4 * 128
PEER_FACTOR = 1.5
PEER_OFFSET = 2e-4
THRESHOLDS = ["--max-block-frac", "0.01", "--max-bias-t", "5", "--max-z-frac", "0.01"]
# the peer does not project the axis of an oblique retarder
EXTRA = {"polarizer_stack": ["--floor", "2e-3"]}
SPECTRAL = {"cornell_spectral"}


def rmse_limits(name: str, samples: int) -> list[float]:
    """Return the RMSE allowed of each component at `samples` samples a pixel."""
    peers = json.loads((REFERENCES / "peer_rmse.json").read_text())["rmse"]
    error = np.load(REFERENCES / f"{name}.npz")["stderr"].astype(float)
    limits = []
    for k, peer in enumerate(peers[name]):
        reference = float(np.mean(error[:, :, k] ** 2))
        noise = max(peer**2 - reference, 0) * PEER_SAMPLES / samples
        limits.append(PEER_FACTOR * (reference + noise) ** 0.5 + PEER_OFFSET)
    return limits


def check(name: str, seeds: int, spp: int) -> bool:
    """Render `name`, print the comparison, and return whether it passed."""
    reference = REFERENCES / f"{name}.npz"
    limits = ",".join(f"{x:.6g}" for x in rmse_limits(name, seeds * spp))
    mode = ["--rgb"] if name in SPECTRAL else []
    with tempfile.TemporaryDirectory() as folder:
        images = [Path(folder) / f"{seed}.exr" for seed in range(1, seeds + 1)]
        for seed, image in enumerate(images, 1):
            options = ["--seed", str(seed), "--spp", str(spp), *mode]
            render(SCENES / name / "scene.xml", image, *options)
        first, *others = map(str, images)
        command = [binary(), "compare", first, str(reference), "--test-seeds", *others]
        command += [*THRESHOLDS, "--max-rmse", limits, *EXTRA.get(name, [])]
        print(f"--- {name}: {seeds} seeds of {spp} samples, --max-rmse {limits}", flush=True)
        status = subprocess.run(command).returncode
    if status not in (0, 1):
        give_up(f"failed with status {status}: {' '.join(command)}")
    return status == 0


def main() -> int:
    """Check the scenes asked for, or all."""
    parser = arguments(__doc__)
    parser.add_argument("scenes", nargs="*", help="names (default: all eight)")
    parser.add_argument("--full", action="store_true", help="128 samples a seed instead of 32")
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--spp", type=int, help="samples a seed")
    args = parser.parse_args()
    spp = args.spp or (128 if args.full else 32)
    names = args.scenes or sorted(p.stem for p in REFERENCES.glob("*.npz"))
    verdicts = {name: check(name, args.seeds, spp) for name in names}
    print("\nReference images\n")
    for name, good in verdicts.items():
        print(f"{name:20} {'agrees' if good else 'DIFFERS'}")
    bad = sum(not good for good in verdicts.values())
    print(f"\n{len(verdicts) - bad} agree, {bad} differ\n")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
