"""The sections of the benchmark's report about how cost grows, from its CSV files."""

from collections.abc import Callable
from statistics import median

from benchmark_scaling import memory_of_a_triangle
from benchmark_stats import geometric_mean
from benchmark_tables import column, digits, groups, markdown

Rows = list[dict[str, str]]
MEGA = 1e6


def polarization(rows: Rows) -> str:
    """Return polarized over unpolarized time: the median over turns."""
    table: list[list[str]] = []
    found: dict[str, list[float]] = {}
    modes = list(dict.fromkeys(row["mode"] for row in rows))
    for (scene,), of_scene in groups(rows, "scene").items():
        cells = [scene]
        for (mode,), turns in groups(of_scene, "mode").items():
            both = [column(turns, name) for name in ("cpu_s", "unpolarized_cpu_s")]
            if mode == modes[0]:
                cells += [digits(float(turns[0]["paths"]) / min(cpu) / MEGA) for cpu in both]
            cost = median(a / b for a, b in zip(*both, strict=True))
            found.setdefault(mode, []).append(cost)
            cells += [f"{cost:.3f}", f"{min(both[0]) / min(both[1]):.3f}"]
        table.append(cells)
    for what, of in (("**geometric mean**", geometric_mean), ("**largest**", max)):
        cells = [what, "", ""]
        for mode in modes:
            cells += [f"**{of(found[mode]):.3f}**", ""]
        table.append(cells)
    head = ["scene", "10⁶ paths per core-second", "unpolarized"]
    for mode in modes:
        head += [f"{mode if mode[0] != '-' else f'`{mode}`'}: cost, median", "of the best"]
    return markdown(head, table)


def threads(rows: Rows) -> str:
    """Return paths per second of one process on all cores, over one process a core."""
    table = []
    for (scene,), turns in groups(rows, "scene").items():
        pairs = zip(column(turns, "together_per_s"), column(turns, "processes_per_s"), strict=True)
        ratio = median(a / b for a, b in pairs)
        cpu = zip(
            column(turns, "together_per_core_s"), column(turns, "processes_per_core_s"), strict=True
        )
        cells = [
            digits(max(column(turns, name)) / MEGA)
            for name in ("together_per_s", "processes_per_s")
        ]
        table.append([scene, *cells, f"{ratio:.3f}", f"{median(a / b for a, b in cpu):.3f}"])
    count = rows[0]["threads"]
    head = ["scene", f"{count} threads, 10⁶ paths/s", f"{count} processes, 10⁶ paths/s"]
    return markdown([*head, "ratio, median", "of CPU time"], table)


def least(rows: Rows, name: str) -> float:
    """Return the least of a column."""
    return min(column(rows, name))


def triangles(rows: Rows) -> str:
    """Return what meshes cost: rays, loading, memory."""
    table = []
    for (count,), turns in groups(rows, "triangles").items():
        cpu = least(turns, "cpu_s")
        cells = [f"{int(count):,}".replace(",", " "), digits(float(turns[0]["rays"]) / cpu / MEGA)]
        cells += [digits(float(turns[0]["paths"]) / cpu / MEGA)]
        cells += [digits(least(turns, "start_wall_s")), digits(least(turns, "start_cpu_s"))]
        cells += [
            digits(float(turns[0]["file"]) / MEGA),
            digits(max(column(turns, "memory")) / MEGA),
        ]
        table.append(cells)
    head = ["triangles", "10⁶ rays per core-second", "10⁶ paths", "load and build, s", "CPU s"]
    text = markdown([*head, "file, MB", "most memory held, MB"], table)
    per = memory_of_a_triangle(rows)
    return text + f"\nFrom the smallest to the largest: {digits(per)} bytes a triangle.\n"


def growth(rows: Rows, name: str, unit: Callable[[float], str] = digits) -> str:
    """Return time and error over one count, relative to the first row too."""
    table, first = [], {}
    scenes = "scene" in rows[0]
    for key, turns in groups(rows, *(["scene"] if scenes else []), name).items():
        cpu = least(turns, "cpu_s") / float(turns[0]["paths"])
        pixel = cpu * float(turns[0]["paths"])
        cost = median(column(turns, "to_target_s"))
        base = first.setdefault(key[0] if scenes else "", (pixel, cost))
        cells = [" ".join(key), unit(1e6 * cpu), digits(pixel), digits(pixel / base[0])]
        cells += [f"{median(column(turns, 'error')):.3f}", digits(cost), digits(cost / base[1])]
        table.append(cells)
    head = [name, "µs a path", "CPU s", "× first", "error", "CPU s to 1 %", "× first"]
    return markdown(head, table)
