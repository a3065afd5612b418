"""Scene files of extremes: sizes, slivers, long paths, strong and weak lamps, long and short waves.

A box has its walls at ±1 times the scale, lengths in metres; `core` fills it.
"""

import numpy as np

# samples a pixel, and pixels along an edge
SAMPLES, SIZE = 16, 32
WALLS = {
    "floor": ('<rotate x="1" y="0" z="0" angle="-90"/>', (0, -1, 0)),
    "ceiling": ('<rotate x="1" y="0" z="0" angle="90"/>', (0, 1, 0)),
    "back": ("", (0, 0, -1)),
    "front": ('<rotate x="0" y="1" z="0" angle="180"/>', (0, 0, 1)),
    "left": ('<rotate x="0" y="1" z="0" angle="90"/>', (-1, 0, 0)),
    "right": ('<rotate x="0" y="1" z="0" angle="-90"/>', (1, 0, 0)),
}
METAL = """<bsdf type="conductor">
    <spectrum name="eta" value="0.2"/><spectrum name="k" value="3.2"/></bsdf>"""
GLASS = """<bsdf type="dielectric">
    <float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>"""


def matte(reflectance: float) -> str:
    """Return a Lambertian surface."""
    return f'<bsdf type="diffuse"><spectrum name="reflectance" value="{reflectance!r}"/></bsdf>'


def area(radiance: float, more: str = "") -> str:
    """Return an emitter of a shape."""
    value = f'<spectrum name="radiance" value="{radiance!r}"/>'
    return f'<emitter type="area">{value}{more}</emitter>'


def vector(tag: str, xyz: tuple[float, float, float]) -> str:
    """Return a tag with three numbers."""
    return "<{} x='{!r}' y='{!r}' z='{!r}'/>".format(tag, *(float(x) for x in xyz))


def scene(
    content: str,
    *,
    depth: int,
    origin: tuple[float, float, float],
    target: tuple[float, float, float],
    up: tuple[float, float, float] = (0, 1, 0),
    fov: float = 40,
    size: int = SIZE,
) -> str:
    """Return a scene file around `content`."""
    look = " ".join(
        f'{name}="{", ".join(repr(float(x)) for x in xyz)}"'
        for name, xyz in (("origin", origin), ("target", target), ("up", up))
    )
    return f"""<scene version="3.0.0">
<integrator type="path">
    <integer name="max_depth" value="{depth}"/><integer name="rr_depth" value="1000000"/>
</integrator>
<sensor type="perspective"><float name="fov" value="{fov!r}"/>
    <transform name="to_world"><lookat {look}/></transform>
    <film type="hdrfilm">
        <integer name="width" value="{size}"/><integer name="height" value="{size}"/>
        <rfilter type="box"/>
    </film>
</sensor>
{content}
</scene>
"""


def wall(name: str, content: str, scale: float = 1, at: float = 0, overlap: float = 1) -> str:
    """Return one wall of a box whose middle is at x = `at`."""
    turn, (x, y, z) = WALLS[name]
    place = vector("translate", (x * scale + at, y * scale, z * scale))
    half = scale * overlap
    grow = vector("scale", (half, half, 1))
    move = f'<transform name="to_world">{grow}{turn}{place}</transform>'
    return f'<shape type="rectangle">{move}{content}</shape>'


def ball(at: tuple[float, float, float], radius: float, scale: float, bsdf: str) -> str:
    """Return a sphere."""
    x, y, z = (c * scale for c in at)
    centre = f'<point name="center" x="{x!r}" y="{y!r}" z="{z!r}"/>'
    size = f'<float name="radius" value="{radius * scale!r}"/>'
    return f'<shape type="sphere">{centre}{size}{bsdf}</shape>'


def core(scale: float, radiance: float) -> str:
    """Return matte walls, a polarized lamp, a metal and a glass ball."""
    walls = "".join(wall(name, matte(0.6), scale, overlap=1.01) for name in WALLS)
    grow = vector("scale", (0.3 * scale, 0.3 * scale, 1))
    turn = WALLS["ceiling"][0]
    place = vector("translate", (0, 0.98 * scale, 0))
    move = f'<transform name="to_world">{grow}{turn}{place}</transform>'
    state = '<string name="stokes" value="1, 0.5, 0.3, 0.2"/>'
    lamp = f'<shape type="rectangle">{move}{matte(0)}{area(radiance, state)}</shape>'
    balls = ball((-0.45, -0.6, -0.2), 0.38, scale, METAL)
    return walls + lamp + balls + ball((0.45, -0.6, 0.1), 0.36, scale, GLASS)


def box(scale: float = 1, radiance: float = 10) -> str:
    """Return the box of matter, seen from inside."""
    origin, target = (0.1 * scale, 0.1 * scale, 0.9 * scale), (0.0, -0.2 * scale, 0.0)
    return scene(core(scale, radiance), depth=8, origin=origin, target=target, fov=75)


def mirror_box(depth: int) -> str:
    """Return a box whose walls shine with radiance 1 and reflect everything."""
    perfect = '<bsdf type="conductor"/>' + area(1)
    walls = "".join(wall(name, perfect) for name in WALLS)
    return scene(walls, depth=depth, origin=(0.11, 0.07, 0.3), target=(0.5, -0.3, -0.9), fov=60)


def white_sphere(depth: int) -> str:
    """Return a closed matt sphere, seen from inside, that reflects everything and shines with 1."""
    inward = '<boolean name="flip_normals" value="true"/>'
    sphere = ball((0.0, 0.0, 0.0), 1, 1, inward + matte(1) + area(1))
    return scene(sphere, depth=depth, origin=(0.2, 0.1, 0.3), target=(0.5, -0.3, -0.9), fov=60)


def corridor(bounces: int, state: tuple[float, float, float]) -> str:
    """Return two perfect mirrors that light passes at 45 degrees between so many reflections.

    The mirrors stand at y = ±1/2 and end at x = `bounces`; the sky is polarized, frame along z,
    which is the s axis, and so is the sensor's.
    """
    shapes = ""
    for turn, y in ((WALLS["floor"][0], -0.5), (WALLS["ceiling"][0], 0.5)):
        grow = vector("scale", ((bounces + 2) / 2, 1, 1))
        # from x = -2, so that nothing is seen past the near end
        place = vector("translate", ((bounces - 2) / 2, y, 0))
        move = f'<transform name="to_world">{grow}{turn}{place}</transform>'
        shapes += f'<shape type="rectangle">{move}<bsdf type="conductor"/></shape>'
    numbers = ", ".join(map(repr, (1.0, *state)))
    sky = f"""<emitter type="constant"><spectrum name="radiance" value="1"/>
        <string name="stokes" value="{numbers}"/><vector name="frame" x="0" y="0" z="1"/>
        </emitter>"""
    return scene(
        sky + shapes, depth=bounces + 10, origin=(0, 0, 0), target=(1, 1, 0), up=(-1, 1, 0),
        fov=1e-5, size=2,
    )  # fmt: skip


def two_rooms(ours: float, theirs: float) -> str:
    """Return the box of matter beside another room whose lamp is another; walls overlap."""
    ceiling = f"{WALLS['ceiling'][0]}{vector('translate', (3, 0.9, 0))}"
    lamp = f'<transform name="to_world">{vector("scale", (0.5, 0.5, 1))}{ceiling}</transform>'
    room = "".join(wall(name, matte(0.6), at=3, overlap=1.01) for name in WALLS)
    other = f'<shape type="rectangle">{lamp}{matte(0)}{area(theirs)}</shape>' if theirs else ""
    origin, target = (0.1, 0.1, 0.9), (0.0, -0.2, 0.0)
    return scene(core(1, ours) + room + other, depth=8, origin=origin, target=target, fov=75)


def sliver_mesh(strips: int, width: float, frame: bool) -> str:
    """Return an OBJ file of strips 2 long and `width` wide, side by side about x = 0, facing +z.

    Each is cut into two triangles.  With `frame` large pieces on both sides make it the square ±1.
    """
    edges = (np.arange(strips + 1) - strips / 2) * width
    if frame:
        edges = np.concatenate([[-1.0], edges, [1.0]])
    lines = [f"v {x!r} {y} 0" for x in edges.tolist() for y in (-1, 1)]
    for i in range(len(edges) - 1):
        a = 2 * i + 1
        lines += [f"f {a} {a + 2} {a + 3}", f"f {a} {a + 3} {a + 1}"]
    return "\n".join(lines) + "\n"


def sliver_wall(width: float, strips: int, angle: float) -> str:
    """Return black slivers before a bright sky, seen so closely that they fill the picture."""
    turn = f'<rotate x="0.3" y="0.2" z="1" angle="{angle!r}"/>'
    mesh = f"""<shape type="obj"><string name="filename" value="mesh.obj"/>
        <transform name="to_world">{turn}</transform>
        <bsdf type="twosided">{matte(0)}</bsdf></shape>"""
    sky = '<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>'
    fov = float(np.degrees(2 * np.arctan(strips * width / 4)))
    return scene(sky + mesh, depth=3, origin=(0, 0, 4), target=(0, 0, 0), fov=fov, size=64)


def sliver_lamp(shape: str, radiance: float) -> str:
    """Return a floor under a lamp of this shape, which faces down from y = 1."""
    move = f"{WALLS['ceiling'][0]}{vector('translate', (0, 0.5, 0))}"
    shine = matte(0) + area(radiance)
    lamp = f'{shape}<transform name="to_world">{{}}{move}</transform>{shine}</shape>'
    floor = wall("floor", matte(0.8), 1)
    return scene(floor + lamp, depth=3, origin=(0, 0.4, 3), target=(0, -0.8, 0), fov=30)


def mirror_floor(bsdf: str, grazing: float) -> str:
    """Return a wide floor under a bright sky, one pixel at this angle from the plane."""
    grow = vector("scale", (1e7, 1e7, 1))
    floor = f'<shape type="rectangle"><transform name="to_world">{grow}</transform>{bsdf}</shape>'
    sky = '<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>'
    target = (float(np.cos(grazing)), 0.0, 1 - float(np.sin(grazing)))
    return scene(
        sky + floor, depth=2, origin=(0, 0, 1), target=target, up=(0, 0, 1), fov=1e-6, size=1
    )


def plate(bsdf: str, degrees: float) -> str:
    """Return a plate that mirrors a polarized sky into one pixel."""
    sin, cos = float(np.sin(np.radians(degrees))), float(np.cos(np.radians(degrees)))
    sky = """<emitter type="constant"><spectrum name="radiance" value="1"/>
        <string name="stokes" value="1, 0, 0.6, 0.3"/><vector name="frame" x="0" y="1" z="0"/>
        </emitter>"""
    shape = f'<shape type="rectangle">{bsdf}</shape>'
    origin = (4 * sin, 0.0, 4 * cos)
    return scene(sky + shape, depth=2, origin=origin, target=(0, 0, 0), fov=0.01, size=8)
