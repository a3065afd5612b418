"""Stress test: Brewster's numbers against mpmath from one end of the 64-bit range to the other.

Inputs are the 64-bit numbers themselves.  For each region of order, argument and condition number
the table shows

    relative  worst relative error (large at zeros of a function)
    units     worst error in ε max(scale, |value| + sensitivity); the sensitivity is what one ulp of
              each input does, the scale what the computation adds up (the envelope of h_n, the
              block of modes that a turn of the axes mixes, the norm of a series)
    share     worst error over what is allowed, which is C ε scale with C = 16 √(n + 1) for order n:
              a recurrence loses at most 4.5 ε of its envelope per step, errors of steps add up like
              a random walk, and 3.5 standard deviations of it are allowed.  Ψ from Θ is held to
              what its documentation promises, 5 ε of the value; light, to what rounded inputs cost

ε is 2^-52, with --f32 2^-23.  Below 1e-308 the spacing of denormal numbers comes on top.  A number
that is missing, not finite, or zero where the truth is not, fails.  Inputs outside the domain must
be refused by name while other cases of the file are computed.
"""

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import stress_changes
import stress_functions
from common import arguments
from evaluate import Outcome, run
from mpmath import mp
from stress import LEAST, Question, at
from stress_domain import OUTSIDE, SOUND

DIGITS = 60
SWEEPS: list[Callable[[bool], Iterator[Question]]] = [
    stress_functions.hermite_questions,
    stress_functions.narrowed_questions,
    stress_functions.phi_questions,
    stress_functions.narrow_phi_questions,
    stress_functions.psi_questions,
    stress_changes.overlap_questions,
    stress_changes.high_overlap_questions,
    stress_changes.power_questions,
    stress_changes.projection_questions,
    stress_changes.light_questions,
]
Falsify = Callable[[float], float]


@dataclass
class Region:
    """What was found in one region."""

    cases: int = 0
    relative: float = 0.0
    units: float = 0.0
    share: float = 0.0
    worst: str = ""


def judge(
    asked: list[Question], outcome: Outcome, regions: dict[str, Region], falsify: Falsify
) -> None:
    """Compare the results of one run with what was expected, region by region."""
    for question, result in zip(asked, outcome.results, strict=True):
        region = regions.setdefault(question.region, Region())
        region.cases += 1
        for path, expected in question.expected.items():
            found = at(result, path)
            if found is not None:
                found = falsify(found)
            units, share = expected.units(found, question.kind)
            region.units = max(region.units, units)
            if np.isfinite(share) and abs(expected.value) > LEAST[question.kind][0]:
                error = abs(mp.mpmathify(found) - expected.value) / abs(expected.value)
                region.relative = max(region.relative, float(error))
            if not share <= region.share:
                region.share = share
                true = mp.nstr(expected.value, 17)
                region.worst = f"{question.case} {path}: found {found}, true {true}"


def refusals() -> list[str]:
    """Return what is wrong with how inputs outside the domain are received."""
    outcome = run([*OUTSIDE.values(), *SOUND])
    complaints = outcome.complaints.splitlines()
    wrong = []
    for i, (name, result) in enumerate(zip(OUTSIDE, outcome.results, strict=False)):
        if result is not None:
            wrong.append(f"{name}: accepted, result {result}")
        elif not any(outcome.identifier(i) in line for line in complaints):
            wrong.append(f"{name}: refused without a word")
    for case, result in zip(SOUND, outcome.results[len(OUTSIDE) :], strict=True):
        if result is None:
            wrong.append(f"{case}: not computed because of its neighbours")
    if outcome.status != 1:
        wrong.append(f"exit status {outcome.status}, expected 1")
    return wrong


def show(regions: dict[str, Region]) -> int:
    """Print the table and the worst case of every region that fails; return their number."""
    width = max(map(len, regions))
    print(f"{'':{width}} {'cases':>7} {'relative':>9} {'units':>9} {'share':>9}")
    for name, region in regions.items():
        verdict = "ok" if region.share <= 1 else "FAIL"
        numbers = f"{region.relative:9.2g} {region.units:9.3g} {region.share:9.3g}"
        print(f"{name:{width}} {region.cases:7} {numbers}  {verdict}")
    failed = {name: region for name, region in regions.items() if not region.share <= 1}
    for name, region in failed.items():
        print(f"\n{name}: worst case\n  {region.worst}")
    return len(failed)


FALSIFIED: dict[str, Falsify] = {
    "numbers below 1e-200 become 0": lambda v: v if abs(v) > 1e-200 else 0.0,
    "twelve digits are kept": lambda v: v * (1 + 1e-12),
    "small numbers lose their sign": lambda v: abs(v) if abs(v) < 1e-9 else v,
    "the largest numbers are not numbers": lambda v: np.nan if abs(v) > 1e9 else v,
}


def main() -> int:
    """Ask, compare, print."""
    parser = arguments(__doc__)
    parser.add_argument("--full", action="store_true", help="sweep more densely (some minutes)")
    parser.add_argument("--self-test", action="store_true", help="also see that errors are noticed")
    args = parser.parse_args()
    mp.dps = DIGITS
    questions = [question for sweep in SWEEPS for question in sweep(args.full)]
    runs = []
    for kind in ("f64", "f32"):
        asked = [question for question in questions if question.kind == kind]
        runs.append((asked, run([question.case for question in asked], single=kind == "f32")))

    def found(falsify: Falsify) -> dict[str, Region]:
        regions: dict[str, Region] = {}
        for asked, outcome in runs:
            judge(asked, outcome, regions, falsify)
        return regions

    print("Stability\n")
    bad = show(found(lambda v: v))
    wrong = refusals()
    print(f"\ninputs outside the domain: {len(OUTSIDE)}, {len(wrong)} of them not refused properly")
    print("".join(f"  {line}\n" for line in wrong))
    if args.self_test:
        print("self-test: regions that fail when the program's answers are falsified")
        for name, falsify in FALSIFIED.items():
            noticed = sum(not region.share <= 1 for region in found(falsify).values())
            print(f"{name:40} {noticed:4}  {'ok' if noticed > bad else 'NOT NOTICED'}")
            bad += noticed <= bad
    return int(bad + len(wrong) > 0)


if __name__ == "__main__":
    sys.exit(main())
