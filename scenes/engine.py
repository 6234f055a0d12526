"""A four-cylinder engine of a car as a CAD model: every part is partly transparent.

Stands for figure 20 of McGuire & Mara 2017, "Phenomenological Transparency": many close layers of
partial coverage, seen from two sides (the views "main" and "rear").

Parameters
----------
detail : float
    Factor on the number of triangles.
near : float
    Distance of the near plane from the camera, m. The engine begins at 0.89 m.

Housings are pale and nearly clear, and the parts inside of them are colored and denser. A ray to
a cylinder crosses hoses, manifold, block, liner, piston and rod, and all of them again behind the
middle. No order of the objects is right: rods lie between the webs of the crankshaft, springs
around valves, belts around gears. A studio light alone shades the parts, as in CAD programs, so
that the picture tests compositing and nothing else. Lengths are millimeters and as in life.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from oitbench.modeling.detail import DETAIL, divisions
from oitbench.modeling.placement import merge, repeated, rotation, transform, translation
from oitbench.modeling.props.engine_parts import (
    belt,
    bolt,
    camshaft,
    connecting_rod,
    crankshaft,
    generator,
    liner,
    piston,
    pulley,
    shell,
    sides,
    spring,
    strip,
    valve,
    wheel,
)
from oitbench.modeling.surroundings import Window, room
from oitbench.modeling.sweeps import around, circle, cylinder, pipe, plate
from oitbench.scene import (
    RGB,
    Camera,
    EnvironmentLight,
    Material,
    Mesh,
    Object,
    Scene,
    Vector,
)

subject = "CAD models"
quick = False
near = 0.85
parameters = {"detail": DETAIL}

PITCH, BORE, THROW, ROD, PIN = 92.0, 40.0, 42.0, 135.0, 24.0
CYLINDERS = tuple((1.5 - index) * PITCH for index in range(4))  # z, from the front to the rear
# Angle of each crankpin from straight up, radians: the outer pistons rise, the inner ones fall.
TURNS = np.radians([38.0, 218.0, 218.0, 38.0])
DECK = 216.0  # lower face of the head
VALVE_TILT = math.radians(22)
CAM = (66.0, 334.0)  # x and y of the camshaft on the right
FRONT, FAN_BELT, REAR = 212.0, 252.0, -232.0  # z of timing gears, outer belt and flywheel

# Coverage and albedo of each paint.
PAINTS: dict[str, tuple[float, RGB]] = {
    "block": (0.17, (0.16, 0.26, 0.36)),
    "liners": (0.20, (0.30, 0.42, 0.50)),
    "head": (0.18, (0.20, 0.30, 0.38)),
    "cover": (0.30, (0.03, 0.11, 0.30)),
    "oil pan": (0.30, (0.12, 0.15, 0.20)),
    "ends": (0.14, (0.30, 0.33, 0.36)),
    "crankshaft": (0.70, (0.44, 0.04, 0.03)),
    "rods": (0.70, (0.58, 0.28, 0.03)),
    "pistons": (0.58, (0.46, 0.46, 0.45)),
    "valves": (0.70, (0.03, 0.32, 0.30)),
    "springs": (0.85, (0.62, 0.42, 0.04)),
    "camshafts": (0.70, (0.34, 0.06, 0.30)),
    "gears": (0.64, (0.06, 0.30, 0.08)),
    "belts": (0.70, (0.03, 0.03, 0.035)),
    "flywheel": (0.46, (0.26, 0.23, 0.19)),
    "accessories": (0.40, (0.24, 0.25, 0.27)),
    "intake": (0.34, (0.04, 0.22, 0.46)),
    "exhaust": (0.46, (0.42, 0.13, 0.04)),
    "hoses": (0.64, (0.02, 0.02, 0.025)),
    "bolts": (0.85, (0.14, 0.145, 0.16)),
}
CAMERA = Camera(position=(-790, 640, 900), target=(14, 136, 20), fov_y=math.radians(31))
REAR_VIEW = Camera(
    position=(850, 430, -940), target=(-14, 130, 0), fov_y=math.radians(32), near=900.0
)


def build(*, name: str, detail: float) -> Scene:
    """Return the engine, one object for each paint."""
    meshes = {
        **_moving(detail),
        **_housing(detail),
        **_drives(detail),
        **_ducts(detail),
        "bolts": _bolts(detail),
    }
    objects = tuple(
        Object(paint, meshes[paint], Material(coverage=coverage, albedo=albedo, specular=0.0))
        for paint, (coverage, albedo) in PAINTS.items()
    )
    return Scene(
        name=name,
        camera=CAMERA,
        views={"rear": REAR_VIEW},
        objects=objects,
        lights=(_studio(),),
        meters_per_unit=0.001,
        full_samples=24,
    )


def _moving(detail: float) -> dict[str, Mesh]:
    """Return the crankshaft, rods, pistons, valves, springs and camshafts."""
    rods, pistons = [], []
    for z, turn in zip(CYLINDERS, TURNS, strict=True):
        x, y = THROW * math.sin(turn), THROW * math.cos(turn)
        lean = math.asin(x / ROD)
        pin = y + ROD * math.cos(lean)
        placed = translation((x, y, z)) @ rotation((0, 0, 1), lean)
        rods.append(transform(connecting_rod(ROD, PIN + 0.5, detail), placed))
        pistons.append(transform(piston(BORE - 0.6, detail), translation((0, pin, z))))
        rods.append(cylinder((0, pin, z - 31), (0, pin, z + 31), 11, 1, sides(detail, 0.5)))
    valves, springs = [], []
    lobes = np.array([z + side for z in CYLINDERS for side in (-19, 19)])
    cams = []
    for side in (-1, 1):
        tilt = rotation((0, 0, 1), -side * VALVE_TILT)
        for z in lobes:
            seat = translation((side * 21.0, DECK + 3.3, z)) @ tilt
            valves.append(transform(valve(detail), seat))
            springs.append(transform(spring(38, 80, 10.5, 6, detail), seat))
        shaft = camshaft(430, lobes, np.repeat(2 * TURNS + side * 0.9, 2), detail)
        cams.append(transform(shaft, translation((side * CAM[0], CAM[1], 4))))
    return {
        "crankshaft": crankshaft(THROW, PIN, PITCH, TURNS, detail),
        "rods": merge(rods),
        "pistons": merge(pistons),
        "valves": merge(valves),
        "springs": merge(springs),
        "camshafts": merge(cams),
    }


def _housing(detail: float) -> dict[str, Mesh]:
    """Return the block with its bulkheads, the liners, the head, its cover and the oil pan."""
    case = [(-72.0, -48.0, 22.0), (72.0, -48.0, 22.0), (0.0, 0.0, 99.0)]
    case += [(-60.0, DECK - 12, 9.0), (60.0, DECK - 12, 9.0)]
    jacket = [(x, y, 8.0) for x in (-52.0, 52.0) for y in (104.0, DECK - 16)]
    parts = [shell(case, 5, 394, detail), shell(jacket, 3, 380, detail)]
    count = sides(detail, 2)
    inside = [(x, y, radius - 6) for x, y, radius in case[:3]]
    for index in range(5):
        z = (2 - index) * 0.98 * PITCH
        wall = plate(around(inside, count), circle(29, count), 9)
        cap = plate(around([(-34, -28, 8), (34, -28, 8), (0, 4, 38)], count), circle(30, count), 26)
        parts += [transform(part, translation((0, 0, z))) for part in (wall, cap)]
    sleeve = liner(BORE, BORE + 5, 92, DECK - 2, detail)
    top = [(x, y, 8.0) for x in (-90.0, 90.0) for y in (DECK + 12, 307.0)]
    head = [shell(top, 6, 396, detail)]
    for z in CYLINDERS:
        for side in (-1, 1):
            port = [(side * 30, 226, z), (side * 40, 262, z), (side * 98, 262, z)]
            head.append(pipe(port, 17, divisions(14, detail, 5), sides(detail, 0.6)))
    cover = [(-90.0, 330.0, 6.0), (90.0, 330.0, 6.0), (-56.0, 366.0, 24.0), (56.0, 366.0, 24.0)]
    pan = [(-84.0, -82.0, 6.0), (84.0, -82.0, 6.0), (-52.0, -142.0, 22.0), (52.0, -142.0, 22.0)]
    tray = [shell(pan, 4, 386, detail)]
    bottom = around([(x, y, radius - 4.5) for x, y, radius in pan], count)
    for z in (-191.0, 191.0):
        end = plate(bottom, circle(12, count, (0, -100)), 4)
        tray.append(transform(end, translation((0, 0, z))))
    edges = [
        [strip((side * (half - 7), level, 0), (14.0, 5.0, 394.0)) for side in (-1, 1)]
        for level, half in ((334.0, 109.0), (-84.5, 104.0))
    ]
    front = [(0.0, 0.0, 58.0), (-66.0, 334.0, 78.0), (66.0, 334.0, 78.0), (52.0, 160.0, 40.0)]
    lid = transform(shell(front, 3, 34, detail), translation((0, 0, FRONT)))
    bell = transform(shell([(0.0, 0.0, 148.0)], 5, 62, detail), translation((0, 0, REAR - 6)))
    return {
        "block": merge(parts),
        "liners": merge([transform(sleeve, translation((0, 0, z))) for z in CYLINDERS]),
        "head": merge(head),
        "cover": merge([shell(cover, 4, 402, detail), *edges[0]]),
        "oil pan": merge([*tray, *edges[1]]),
        "ends": merge([lid, bell]),
    }


def _drives(detail: float) -> dict[str, Mesh]:
    """Return the timing gears, both belts, the flywheel, and the parts that the belts drive."""
    teeth = [(0.0, 0.0, 20, 34.0, 14.0), (46.0, 160.0, 16, 27.0, 9.0)]
    teeth += [(side * CAM[0], CAM[1], 40, 64.0, 11.0) for side in (-1, 1)]
    gears = [
        transform(wheel(number, radius, bore, 17, detail), translation((x, y, FRONT)))
        for x, y, number, radius, bore in teeth
    ]
    gears.append(cylinder((0, 0, 163), (0, 0, FRONT + 52), 13.5, 1, sides(detail, 0.6)))
    pulleys = [(0.0, 0.0, 66.0), (-150.0, 96.0, 30.0), (96.0, 104.0, 40.0)]
    timing = belt([(x, y, radius) for x, y, _, radius, _ in teeth], 1, 4.5, 20, detail)
    fan = belt(pulleys, 1, 4.5, 13, detail)
    driven = [
        transform(pulley(radius, 19, detail), translation((x, y, FAN_BELT)))
        for x, y, radius in pulleys
    ]
    left, right = pulleys[1], pulleys[2]
    driven += [
        transform(generator(detail), translation((left[0], left[1], FAN_BELT))),
        cylinder((*right[:2], 180), (*right[:2], 236), 34, 6, sides(detail)),
        # The oil filter, and the pipe through which the pump draws oil from the pan.
        cylinder((-126, -30, -60), (-96, -30, -60), 30, 3, sides(detail, 0.7)),
        cylinder((-205, -30, -60), (-127, -30, -60), 38, 9, sides(detail)),
        cylinder((0, -146, 20), (0, -128, 20), 36, 4, sides(detail)),
        pipe(
            [(0, -126, 20), (0, -104, 20), (0, -104, 150), (0, -60, 176)],
            9, divisions(20, detail, 6), sides(detail, 0.5),
        ),
    ]  # fmt: skip
    return {
        "gears": merge(gears),
        "belts": merge(
            [
                transform(timing, translation((0, 0, FRONT))),
                transform(fan, translation((0, 0, FAN_BELT))),
            ]
        ),
        "flywheel": transform(wheel(110, 134, 15, 20, detail), translation((0, 0, REAR))),
        "accessories": merge(driven),
    }


def _ducts(detail: float) -> dict[str, Mesh]:
    """Return the intake and the exhaust manifold, hoses, the fuel rail, spark plugs and leads."""

    def duct(corners: Sequence[Vector], radius: float) -> Mesh:
        return pipe(corners, radius, divisions(24, detail, 6), sides(detail, 0.6))

    intake = [cylinder((-226, 352, -190), (-226, 352, 180), 40, 14, sides(detail))]
    intake.append(cylinder((-226, 352, 184), (-226, 352, 236), 29, 3, sides(detail)))
    exhaust = []
    thin = [cylinder((-128, 322, -170), (-128, 322, 170), 8, 2, sides(detail, 0.4))]
    for z in CYLINDERS:
        runner = [(-101, 262, z), (-150, 262, z), (-205, 240, z), (-226, 280, z), (-226, 316, z)]
        intake.append(duct(runner, 20))
        end = 0.25 * z - 30  # the pipes meet
        exhaust.append(
            duct([(101, 258, z), (150, 262, z), (176, 200, z), (176, 120, end), (172, 20, end)], 18)
        )
        thin += [
            cylinder((-128, 315, z), (-108, 262, z), 5.5, 1, sides(detail, 0.3)),
            cylinder((0, 226, z), (0, 398, z), 9, 2, sides(detail, 0.4)),
            duct([(0, 399, z), (0, 430, z), (70, 430, z - 30), (120, 400, -160)], 4),
        ]
    outlet = [(172, 34, -30), (172, -10, -30), (168, -62, -60), (160, -74, -130), (160, -74, -180)]
    exhaust.append(duct(outlet, 30))
    upper = [(30, 300, 206), (40, 290, 300), (90, 250, 330), (170, 200, 330), (190, 110, 300)]
    lower = [(96, 60, 208), (110, 20, 230), (150, -30, 290), (190, -60, 300)]
    breather = [
        (96, 270, -190),
        (130, 330, -200),
        (60, 420, -150),
        (-80, 424, -60),
        (-160, 380, 40),
    ]
    thin += [duct(upper, 21), duct(lower, 21), duct(breather, 11)]
    return {"intake": merge(intake), "exhaust": merge(exhaust), "hoses": merge(thin)}


def _bolts(detail: float) -> Mesh:
    """Return the bolts of the cover, the oil pan and the flywheel."""
    rows = np.linspace(-178, 178, 7)
    down, forward = rotation((0, 0, 1), math.pi), rotation((1, 0, 0), -math.pi / 2)
    pan, hub = transform(bolt(30, 4, detail), down), transform(bolt(24, 5, detail), forward)
    kinds = (
        (bolt(46, 4, detail), [(x, 336.9, z) for x in (-102.0, 102.0) for z in rows]),
        (pan, [(x, -87.4, z) for x in (-97.0, 97.0) for z in rows]),
        (hub, [(x, y, REAR - 11) for x, y in circle(30, 8)]),
    )
    return merge([repeated(*kind) for kind in kinds])


def _studio() -> EnvironmentLight:
    """Return an even, pale studio with two large lights above."""
    windows = (
        Window(azimuth=-0.9, elevation=0.75, width=1.0, height=0.7, radiance=(11.0, 11.0, 10.6)),
        Window(azimuth=2.4, elevation=0.65, width=1.0, height=0.6, radiance=(3.0, 3.1, 3.4)),
    )
    return room((0.70, 0.72, 0.75), (0.80, 0.82, 0.85), (0.50, 0.52, 0.56), windows)
