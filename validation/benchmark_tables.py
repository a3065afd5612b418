"""CSV files of the benchmark, and Markdown tables."""

import csv
from pathlib import Path
from typing import Any

Row = dict[str, Any]


def write(path: Path, made: str, rows: list[Row]) -> None:
    """Write rows as CSV whose first line says what made it; five digits a number."""

    def text(value: Any) -> str:  # noqa: ANN401
        return f"{value:.5g}" if isinstance(value, float) else str(value)

    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as out:
        out.write(f"# made by: {made}\n")
        writer = csv.DictWriter(out, fieldnames=list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows({k: text(v) for k, v in row.items()} for row in rows)


def read(path: Path) -> tuple[str, list[dict[str, str]]]:
    """Return what made a CSV, and its rows; nothing where there is no such file."""
    if not path.exists():
        return "", []
    lines = path.read_text(encoding="utf-8").splitlines()
    return lines[0].removeprefix("# made by: "), list(csv.DictReader(lines[1:]))


def markdown(head: list[str], rows: list[list[str]]) -> str:
    """Return a table: the first column to the left, the others to the right."""
    lines = [f"| {' | '.join(head)} |", "|---" + "|---:" * (len(head) - 1) + "|"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows)]) + "\n"


def digits(value: float) -> str:
    """Return three digits."""
    if value != value:
        return "–"
    return f"{value:,.0f}".replace(",", " ") if 1e3 <= abs(value) < 1e7 else f"{value:.3g}"


def groups(rows: list[dict[str, str]], *names: str) -> dict[tuple[str, ...], list[dict[str, str]]]:
    """Return rows by the values of these columns, in the order of the file."""
    found: dict[tuple[str, ...], list[dict[str, str]]] = {}
    for row in rows:
        found.setdefault(tuple(row[name] for name in names), []).append(row)
    return found


def column(rows: list[dict[str, str]], name: str) -> list[float]:
    """Return a column as numbers."""
    return [float(row[name]) for row in rows]
