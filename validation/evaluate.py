"""Numbers from Brewster: a list of cases in, `brewster eval`, a list of results out.

A case is `(op, inputs)`; numbers are written so that they read back as the same 64-bit number.
"""

import json
import secrets
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from common import Report, arguments, binary, give_up

Case = tuple[str, dict[str, Any]]
# None where the program refused a case
Result = dict[str, Any] | None
Tamper = Callable[[Case, dict[str, Any]], dict[str, Any]]


def written(value: Any) -> Any:  # noqa: ANN401
    """Return `value` as the schema writes it: reals as decimal strings, complex as re and im."""
    if isinstance(value, dict):
        return {key: written(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [written(entry) for entry in value]
    if isinstance(value, complex | np.complexfloating):
        return {"re": repr(float(value.real)), "im": repr(float(value.imag))}
    if isinstance(value, float | np.floating):
        return repr(float(value))
    if isinstance(value, np.integer):
        return int(value)
    return value


def read(value: Any) -> Any:  # noqa: ANN401
    """Return what the schema's `value` means; lists stay lists, strings that are numbers such."""
    if isinstance(value, dict):
        if set(value) == {"re", "im"}:
            return complex(float(value["re"]), float(value["im"]))
        return {key: read(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [read(entry) for entry in value]
    try:
        return float(value)
    except ValueError:
        return value


@dataclass
class Outcome:
    """What one run of the program gave: results in the order of the cases, and complaints."""

    results: list[Result]
    status: int
    complaints: str

    @staticmethod
    def identifier(i: int) -> str:
        """Return the id of the i-th case, no part of another one's."""
        return f"case-{i:07}"


def run(cases: list[Case], *, single: bool = False) -> Outcome:
    """Run `brewster eval` once; `single` asks for 32-bit basis functions."""
    document = {
        "schema": "hg-oracle-1",
        "group": "validation",
        "cases": [
            {"id": Outcome.identifier(i), "op": op, "inputs": written(inputs)}
            for i, (op, inputs) in enumerate(cases)
        ],
    }
    with tempfile.TemporaryDirectory() as folder:
        asked, answered = Path(folder) / "cases.json", Path(folder) / "results.json"
        asked.write_text(json.dumps(document))
        command = [binary(), "eval", str(asked), "-o", str(answered), *(["--f32"] * single)]
        done = subprocess.run(command, text=True, capture_output=True)
        if done.returncode not in (0, 1) or not answered.exists():
            give_up(f"failed with status {done.returncode}: {' '.join(command)}\n{done.stderr}")
        given = json.loads(answered.read_text())["cases"]
    found = {case["id"]: case["result"] for case in given}
    if len(found) != len(given):
        give_up(f"{len(given) - len(found)} results have the id of another one")
    ids = map(Outcome.identifier, range(len(cases)))
    results = [read(found[name]) if name in found else None for name in ids]
    return Outcome(results, done.returncode, done.stderr)


@dataclass
class Program:
    """The program as the checks call it; `tamper` falsifies its answers.

    After `rewind` the same calls in the same order are answered from memory.
    """

    tamper: Tamper | None = None
    known: list[list[Result]] = field(default_factory=list)
    call: int = 0

    def rewind(self, tamper: Tamper) -> None:
        """Start again, from now on with falsified answers."""
        self.call, self.tamper = 0, tamper

    def __call__(self, cases: list[Case]) -> list[dict[str, Any]]:
        """Return the results of `cases`, none of which may be refused."""
        if self.call == len(self.known):
            outcome = run(cases)
            if refused := outcome.results.count(None):
                give_up(f"{refused} of {len(cases)} cases were refused\n{outcome.complaints}")
            self.known.append(outcome.results)
        results = [result for result in self.known[self.call] if result is not None]
        self.call += 1
        if self.tamper is None:
            return results
        return [self.tamper(case, result) for case, result in zip(cases, results, strict=True)]

    def values(self, cases: list[Case], key: str = "value") -> np.ndarray:
        """Return the one number of each result."""
        return np.array([result[key] for result in self(cases)])


def seed_of(text: str) -> int:
    """Return the seed that an argument names; `random` is another one each time."""
    return secrets.randbelow(2**32) if text == "random" else int(text)


def check(
    documentation: str | None,
    compare: Callable[..., Report],
    falsified: list[Tamper],
    *,
    seed: int | None = None,
) -> int:
    """Run `compare`, and with `--self-test` again on answers falsified in turn.

    Each falsification must be noticed.  With `seed`, which `--seed` replaces, `compare` is also
    given the seed of its cases.  Returns the exit status.
    """
    parser = arguments(documentation)
    parser.add_argument("--self-test", action="store_true", help="also see that errors are noticed")
    if seed is not None:
        what = "of the cases: a number, or `random` for other ones each time"
        parser.add_argument("--seed", type=seed_of, default=seed, help=what)
    args = parser.parse_args()
    seeds = [] if seed is None else [args.seed]
    program = Program()
    status = compare(program, *seeds).finish()
    print(f"{sum(map(len, program.known))} cases evaluated")
    if not args.self_test:
        return status
    print("\nself-test: rows that differ when the program's answers are falsified\n")
    for tamper in falsified:
        program.rewind(tamper)
        bad = sum(not good for *_, good in compare(program, *seeds).rows)
        status = max(status, int(bad == 0))
        print(f"{tamper.__name__.replace('_', ' '):24} {bad:4}  {'ok' if bad else 'NOT NOTICED'}")
    return status
