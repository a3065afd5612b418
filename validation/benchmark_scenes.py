"""The benchmark's scenes: bundled ones, those that grow, and a box without polarizing matter."""

from pathlib import Path

import numpy as np
from common import SCENES

# the six of the table beside Mitsuba: grey, so that one wavelength stands for all
SIX = [
    "fresnel_sphere", "furnace_sphere", "cornell", "polarizer_stack", "rough_conductor", "big_mesh",
]  # fmt: skip
# whose light and matter follow the wavelength, and which Mitsuba renders too
COLOURED = ["cornell_spectral"]
HEAD = """<scene version="3.0.0">
<integrator type="path">
    <integer name="max_depth" value="5"/><integer name="rr_depth" value="1000"/>
</integrator>
<sensor type="perspective">
    <float name="fov" value="32"/>
    <transform name="to_world">
        <lookat origin="0.3, 2.4, 6" target="0, 0.9, 0" up="0, 1, 0"/>
    </transform>
    <film type="hdrfilm">
        <integer name="width" value="256"/><integer name="height" value="256"/>
        <rfilter type="box"/>
    </film>
</sensor>
"""
FLOOR = """<shape type="rectangle">
    <transform name="to_world">
        <scale x="4" y="4" z="1"/><rotate x="1" y="0" z="0" angle="-90"/>
    </transform>
    <bsdf type="diffuse"><spectrum name="reflectance" value="0.4"/></bsdf>
</shape>
"""
PLASTIC = """<bsdf type="pplastic">
    <spectrum name="diffuse_reflectance" value="0.35"/><float name="alpha" value="0.15"/>
</bsdf>
"""
LAMP = """<shape type="rectangle">
    <transform name="to_world">
        <scale x="{half}" y="{half}" z="1"/><rotate x="1" y="0" z="0" angle="90"/>
        <translate x="{x}" y="4" z="{z}"/>
    </transform>
    <emitter type="area"><spectrum name="radiance" value="{radiance}"/></emitter>
</shape>
"""
# half-width of the ceiling that lamps are spread over, and of the only lamp
CEILING, LONE_LAMP = 3.0, 1.0


def lamps(count: int) -> str:
    """Return so many lamps on a square grid, together as strong as one."""
    side = int(np.ceil(np.sqrt(count)))
    half = LONE_LAMP / np.sqrt(count)
    places = (np.arange(side) + 0.5) / side * 2 * CEILING - CEILING
    grid = [(x, z) for x in places for z in places][:count]
    return "".join(LAMP.format(half=half, x=x, z=z, radiance=10) for x, z in grid)


def displaced_sphere(triangles: int) -> str:
    """Return an OBJ file of a displaced sphere of about so many triangles, wound outward."""
    parallels = max(round(np.sqrt(triangles / 4)), 3)
    meridians = 2 * parallels
    theta = np.pi * np.arange(1, parallels) / parallels
    phi = 2 * np.pi * np.arange(meridians) / meridians
    t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    unit = np.stack([np.sin(t) * np.cos(p), np.cos(t), np.sin(t) * np.sin(p)], axis=1)
    unit = np.vstack([unit, [0, 1, 0], [0, -1, 0]])
    radius = 0.9 + 0.05 * np.sin(7 * unit).prod(1) + 0.01 * np.sin(29 * unit).prod(1)
    points = unit * radius[:, None] + [0, 1, 0]

    # corners of cells, counted from 1
    i, j = (a.ravel() for a in np.mgrid[: parallels - 2, :meridians])
    here, right = i * meridians + j + 1, i * meridians + (j + 1) % meridians + 1
    below, across = here + meridians, right + meridians
    north, south = len(points) - 1, len(points)
    first = np.arange(meridians) + 1
    second = np.roll(first, -1)
    last = (parallels - 2) * meridians
    faces = np.vstack(
        [
            np.stack([here, right, across], 1),
            np.stack([here, across, below], 1),
            np.stack([np.full(meridians, north), second, first], 1),
            np.stack([np.full(meridians, south), last + first, last + second], 1),
        ]
    )
    lines = ["v %.7g %.7g %.7g" % tuple(p) for p in points.tolist()]  # noqa: UP031
    lines += ["f %d %d %d" % tuple(f) for f in faces.tolist()]  # noqa: UP031
    return "\n".join(lines) + "\n"


def mesh_scene(folder: Path, triangles: int) -> tuple[Path, int]:
    """Write a plastic mesh on a floor; return the scene and how many triangles it has."""
    mesh = displaced_sphere(triangles)
    (folder / "mesh.obj").write_text(mesh)
    shape = f"""<shape type="obj"><string name="filename" value="mesh.obj"/>{PLASTIC}</shape>"""
    scene = folder / "scene.xml"
    scene.write_text(HEAD + FLOOR + shape + lamps(1) + "</scene>\n")
    return scene, mesh.count("\nf ")


def lamp_scene(folder: Path, count: int) -> Path:
    """Write a plastic sphere on a floor under so many lamps."""
    sphere = f"""<shape type="sphere"><point name="center" x="0" y="1" z="0"/>{PLASTIC}</shape>"""
    scene = folder / "scene.xml"
    scene.write_text(HEAD + FLOOR + sphere + lamps(count) + "</scene>\n")
    return scene


def matte_box(folder: Path) -> Path:
    """Write the Cornell box with white plaster in place of metal and glass."""
    lines = (SCENES / "cornell" / "scene.xml").read_text().splitlines()
    smooth = ("metal", "glass")
    kept = [line for line in lines if not any(f'id="{name}">' in line for name in smooth)]
    text = "\n".join(kept) + "\n"
    for name in smooth:
        text = text.replace(f'<ref id="{name}"/>', '<ref id="white"/>')
    scene = folder / "matte_box.xml"
    scene.write_text(text)
    return scene
