#!/usr/bin/env python3
"""Write the meshes that are too large to commit; needs nothing but Python.

    python3 scenes/make_meshes.py

big_mesh/displaced_sphere_200k.obj: a latitude/longitude sphere of 199,808 triangles, displaced
by sines of its position, every triangle wound outward.  A file that is already right is kept.
"""

import hashlib
import math
from pathlib import Path

Point = tuple[float, float, float]
Triangle = tuple[int, int, int]

MERIDIANS = 448
PARALLELS = 224
MESH = Path(__file__).parent / "big_mesh" / "displaced_sphere_200k.obj"
# of the file that the reference image of big_mesh was rendered from
SHA256 = "b3f8c507cbc04ac084fc8159cbda6bc4b4cb6f45fbee05942bae60934a37d364"


def displaced(x: float, y: float, z: float) -> Point:
    """Move a point of the unit sphere along its radius."""
    sin = math.sin
    coarse = 0.06 * sin(7 * x + 1.3) * sin(6 * y) * sin(8 * z + 0.4)
    medium = 0.02 * sin(23 * x) * sin(19 * y + 0.7) * sin(21 * z)
    fine = 0.004 * sin(71 * x + 2 * y) * sin(67 * z - 3 * y)
    r = 1 + coarse + medium + fine
    return (r * x, r * y, r * z)


def vertices() -> list[Point]:
    """Return the parallels from north to south, then the north and the south pole."""
    points = []
    for i in range(1, PARALLELS):
        theta = math.pi * i / PARALLELS
        for j in range(MERIDIANS):
            phi = 2 * math.pi * j / MERIDIANS
            x, z = math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi)
            points.append(displaced(x, math.cos(theta), z))
    return [*points, displaced(0, 1, 0), displaced(0, -1, 0)]


def triangles() -> list[Triangle]:
    """Return two triangles a cell, upper halves first, then the two polar fans."""

    def at(i: int, j: int) -> int:
        return i * MERIDIANS + j % MERIDIANS

    cells = [(i, j) for i in range(PARALLELS - 2) for j in range(MERIDIANS)]
    north, south = at(PARALLELS - 1, 0), at(PARALLELS - 1, 1)
    last = PARALLELS - 2
    return [
        *((at(i, j), at(i, j + 1), at(i + 1, j + 1)) for i, j in cells),
        *((at(i, j), at(i + 1, j + 1), at(i + 1, j)) for i, j in cells),
        *((north, at(0, j + 1), at(0, j)) for j in range(MERIDIANS)),
        *((south, at(last, j), at(last, j + 1)) for j in range(MERIDIANS)),
    ]


def wound_outward(points: list[Point], triangle: Triangle) -> Triangle:
    """Swap two corners where the normal looks at the centre of the sphere."""
    a, b, c = (points[k] for k in triangle)
    # the scalar triple product has the sign of normal · centroid
    volume = (
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
    )
    return triangle if volume >= 0 else (triangle[0], triangle[2], triangle[1])


def obj_text() -> str:
    """Return the mesh as an OBJ file, five digits a coordinate."""
    points = vertices()
    lines = ["v {:.5g} {:.5g} {:.5g}".format(*p) for p in points]
    for triangle in triangles():
        lines.append("f {} {} {}".format(*(k + 1 for k in wound_outward(points, triangle))))
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the mesh, unless it is there and right."""
    if MESH.exists() and hashlib.sha256(MESH.read_bytes()).hexdigest() == SHA256:
        print(f"{MESH}: already there")
        return
    text = obj_text().encode()
    MESH.write_bytes(text)
    same = hashlib.sha256(text).hexdigest() == SHA256
    remark = "" if same else " (some coordinates differ from the reference's in the fifth digit)"
    print(f"{MESH}: written{remark}")


if __name__ == "__main__":
    main()
