"""Named flows for `flow.name`: each a row with its shape, its velocity, its keys, and its papers.

A shape is a NamedTuple of numbers. Its velocity is a compiled function of the shape, the coordinates x (along), y
(across) and z (upward), and the time. In 2D the coordinates are x and z, and y is 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ecume._jit import admit, compiled_inside, selection
from ecume.errors import BadInput
from ecume.laws import carrier_flows, flows, water_waves
from ecume.scenes.tracers import FlowSpec

admit(carrier_flows, flows)

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
"""The lower and the upper corner of the liquid; in 2D its y is 0."""
Point = tuple[float, float, float]


class Channel(NamedTuple):
    """Flow along x between two walls."""

    bottom: float
    width: float
    speed: float


class Couette(NamedTuple):
    """Flow along x between a wall at rest and an upper one that moves."""

    bottom: float
    width: float
    speed: float


class Tube(NamedTuple):
    """Flow along x in a round tube."""

    y: float
    z: float
    radius: float
    speed: float


class Duct(NamedTuple):
    """Flow along x in a rectangular tube."""

    y: float
    z: float
    width: float
    depth: float
    slope: float


class Stagnation(NamedTuple):
    """Flow against a wall or toward a stagnation point; in 3D inward along the vertical and outward in all horizontal
    directions.
    """

    center: Point
    along: float
    across: float
    upward: float


class Rotation(NamedTuple):
    """Rigid rotation: in 2D counterclockwise, in 3D about the vertical."""

    center: Point
    flat: float
    upright: float


class Cellular(NamedTuple):
    """Square cells with alternating rotation, in the vertical plane along x."""

    x: float
    z: float
    wavenumber: float
    speed: float


class DoubleGyre(NamedTuple):
    """Two gyres side by side, with an oscillating border."""

    x: float
    z: float
    half: float
    height: float
    speed: float
    swing: float
    turning: float


class Wave(NamedTuple):
    """A wave of small amplitude that travels along x."""

    bottom: float
    depth: float
    wavenumber: float
    turning: float
    speed: float


class Abc(NamedTuple):
    """Arnold, Beltrami and Childress's flow."""

    center: Point
    wavenumber: float
    speed: float


class Still(NamedTuple):
    """A flow that adds nothing to the uniform one."""

    speed: float


class PastObstacle(NamedTuple):
    """The disturbance of a uniform stream by a round obstacle."""

    center: Point
    radius: float
    stream: Point
    law: int
    """of the row of `DETOURS`"""


@compiled_inside
def still_velocity(shape: Still, x: float, y: float, z: float, time: float) -> Point:
    """Zero velocity."""
    return shape.speed, shape.speed, shape.speed


DETOURS: dict[tuple[str, int], Callable[..., Point]] = {
    ("creeping", 3): carrier_flows.creeping_flow_past_sphere,
    ("ideal", 3): carrier_flows.ideal_flow_past_sphere,
    ("ideal", 2): carrier_flows.ideal_flow_past_cylinder,
}
"""Exact solutions for `flow.around_obstacles`, by its value and the number of dimensions."""
detour = selection(
    "detour", dict(enumerate(DETOURS.values())), __name__, __file__, ("place", "radius", "stream")
)  # fmt: skip


@compiled_inside
def past_obstacle_velocity(shape: PastObstacle, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of the disturbance: the flow past the obstacle minus the uniform stream."""
    center, stream = shape.center, shape.stream
    found = detour((x - center[0], y - center[1], z - center[2]), shape.radius, stream, shape.law)
    return found[0] - stream[0], found[1] - stream[1], found[2] - stream[2]


OTHER_VELOCITIES = {Still: still_velocity, PastObstacle: past_obstacle_velocity}


@compiled_inside
def channel_velocity(shape: Channel, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of a Poiseuille flow between plates; behind a wall, that of the mirror image."""
    height = abs(z - shape.bottom)
    height = height if height < shape.width else 2.0 * shape.width - height
    return flows.channel_speed(height, shape.width, shape.speed), 0.0, 0.0


@compiled_inside
def couette_velocity(shape: Couette, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of a plane Couette flow."""
    return carrier_flows.couette_speed(z - shape.bottom, shape.width, shape.speed), 0.0, 0.0


@compiled_inside
def tube_velocity(shape: Tube, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of a Poiseuille flow in a tube; behind the wall, that of the mirror image."""
    across, up = y - shape.y, z - shape.z
    return carrier_flows.tube_speed(math.sqrt(across * across + up * up), shape.radius, shape.speed), 0.0, 0.0


@compiled_inside
def duct_velocity(shape: Duct, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of a flow in a rectangular duct; behind a wall, that of the mirror image."""
    across, up = abs(y - shape.y), abs(z - shape.z)
    across = across if across < 0.5 * shape.width else shape.width - across
    up = up if up < 0.5 * shape.depth else shape.depth - up
    return carrier_flows.duct_speed(across, up, shape.width, shape.depth, shape.slope), 0.0, 0.0


@compiled_inside
def stagnation_velocity(shape: Stagnation, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of a stagnation-point flow."""
    center = shape.center
    return shape.along * (x - center[0]), shape.across * (y - center[1]), shape.upward * (z - center[2])


@compiled_inside
def rotation_velocity(shape: Rotation, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of a rigid rotation."""
    along, across, up = x - shape.center[0], y - shape.center[1], z - shape.center[2]
    return -shape.flat * up - shape.upright * across, shape.upright * along, shape.flat * along


@compiled_inside
def cellular_velocity(shape: Cellular, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of a cellular flow."""
    k = shape.wavenumber
    found = carrier_flows.cellular_velocity(k * (x - shape.x), k * (z - shape.z), shape.speed)
    return found[0], 0.0, found[1]


@compiled_inside
def double_gyre_velocity(shape: DoubleGyre, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of a double gyre."""
    swing = shape.swing * math.sin(shape.turning * time)
    place, up = (x - shape.x) / shape.half, (z - shape.z) / shape.height
    found = carrier_flows.double_gyre_velocity(place, up, swing, shape.speed)
    return found[0], 0.0, found[1] * shape.height / shape.half


@compiled_inside
def surface_wave_velocity(shape: Wave, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of a surface wave."""
    phase = shape.wavenumber * x - shape.turning * time
    found = carrier_flows.wave_velocity(phase, z - shape.bottom, shape.wavenumber, shape.depth, shape.speed)
    return found[0], 0.0, found[1]


@compiled_inside
def abc_velocity(shape: Abc, x: float, y: float, z: float, time: float) -> Point:
    """The velocity of an ABC flow."""
    k, center = shape.wavenumber, shape.center
    return carrier_flows.abc_velocity(k * (x - center[0]), k * (y - center[1]), k * (z - center[2]), shape.speed)


class Request(NamedTuple):
    """The quantities from which a shape is made."""

    flow: FlowSpec
    box: Box
    center: Point
    dimensions: int
    gravity: float

    def sides(self) -> Point:
        """Length, width and height of the box."""
        low, high = self.box
        return high[0] - low[0], high[1] - low[1], high[2] - low[2]

    def value(self, key: str) -> float:
        """The value of a required key. Raises BadInput if it is missing."""
        value = getattr(self.flow, key)
        if value is None:
            raise BadInput(f"is missing; the flow {self.flow.name} needs it", key)
        return float(value)


def _channel(request: Request) -> Channel:
    return Channel(request.box[0][2], request.sides()[2], request.value("speed"))


def _couette(request: Request) -> Couette:
    return Couette(request.box[0][2], request.sides()[2], request.value("speed"))


def _tube(request: Request) -> Tube:
    radius = request.flow.radius or 0.5 * min(request.sides()[1:])
    return Tube(request.center[1], request.center[2], radius, request.value("speed"))


def _duct(request: Request) -> Duct:
    _, width, depth = request.sides()
    speed = request.value("speed") / carrier_flows.duct_mean(width, depth)
    return Duct(request.center[1], request.center[2], width, depth, speed)


def _stagnation(request: Request) -> Stagnation:
    rate = request.value("rate")
    flat = (rate, 0.0, -rate) if request.dimensions == 2 else (0.5 * rate, 0.5 * rate, -rate)
    return Stagnation(request.center, *flat)


def _rotation(request: Request) -> Rotation:
    rate = request.value("rate")
    return Rotation(request.center, *((rate, 0.0) if request.dimensions == 2 else (0.0, rate)))


def _cellular(request: Request) -> Cellular:
    low = request.box[0]
    start = (low[0], low[2]) if request.flow.center is None else (request.center[0], request.center[2])
    return Cellular(*start, 2.0 * math.pi / request.value("wavelength"), request.value("speed"))


def _double_gyre(request: Request) -> DoubleGyre:
    low, (length, _, height) = request.box[0], request.sides()
    if request.flow.period is not None and not request.flow.swing:
        raise BadInput("is not used without swing; remove it", "period")
    turning = 2.0 * math.pi / request.value("period") if request.flow.swing else 0.0
    return DoubleGyre(
        low[0], low[2], 0.5 * length, height, request.value("speed"), float(request.flow.swing or 0.0), turning
    )


def _wave(request: Request) -> Wave:
    depth, k = request.sides()[2], 2.0 * math.pi / request.value("wavelength")
    if request.gravity == 0.0:
        raise BadInput("got wave without gravity; expected gravity above 0", "name")
    turning = water_waves.wave_frequency(k, depth, request.gravity)
    return Wave(request.box[0][2], depth, k, turning, request.value("speed"))


def _abc(request: Request) -> Abc:
    center = request.box[0] if request.flow.center is None else request.center
    return Abc(center, 2.0 * math.pi / request.value("wavelength"), request.value("speed"))


@dataclass(frozen=True)
class NamedFlow:
    """A row of the table: a flow and everything that depends on it."""

    shape: Callable[[Request], Any]
    """makes the shape; raises BadInput with the key as its second argument"""
    velocity: Callable[..., Point]
    """velocity(shape, x, y, z, time), compiled"""
    papers: tuple[Callable[..., Any], ...]
    keys: frozenset[str]
    """keys of `[flow]` that it uses, beside those of all flows"""
    dimensions: tuple[int, ...] = (2, 3)
    needs_box: bool = False
    """whether it needs the sides of a box: `low` and `high`, by default those of the tank"""
    walls: str = ""
    """the axes across which no liquid flows at the sides of the box"""


BOX = frozenset({"low", "high"})
NAMED_FLOWS = {
    "channel": NamedFlow(
        _channel, channel_velocity, (flows.channel_speed,), BOX | {"speed"}, needs_box=True, walls="z"
    ),
    "couette": NamedFlow(
        _couette, couette_velocity, (carrier_flows.couette_speed,), BOX | {"speed"}, needs_box=True, walls="z"
    ),
    "tube": NamedFlow(
        _tube, tube_velocity, (carrier_flows.tube_speed,), BOX | {"speed", "radius", "center"}, (3,), needs_box=True,
        walls="yz",
    ),
    "duct": NamedFlow(
        _duct, duct_velocity, (carrier_flows.duct_speed, carrier_flows.duct_mean), BOX | {"speed"}, (3,),
        needs_box=True, walls="yz",
    ),
    "stagnation": NamedFlow(
        _stagnation, stagnation_velocity, (), frozenset({"rate", "center"})
    ),
    "rotation": NamedFlow(_rotation, rotation_velocity, (), frozenset({"rate", "center"})),
    "cellular": NamedFlow(
        _cellular, cellular_velocity, (carrier_flows.cellular_velocity,),
        frozenset({"speed", "wavelength", "center"}),
    ),
    "double-gyre": NamedFlow(
        _double_gyre, double_gyre_velocity, (carrier_flows.double_gyre_velocity,),
        BOX | {"speed", "period", "swing"}, needs_box=True, walls="xz",
    ),
    "wave": NamedFlow(
        _wave, surface_wave_velocity, (carrier_flows.wave_velocity, water_waves.wave_frequency),
        BOX | {"speed", "wavelength"}, needs_box=True,
    ),
    "abc": NamedFlow(
        _abc, abc_velocity, (carrier_flows.abc_velocity,), frozenset({"speed", "wavelength", "center"}), (3,)
    ),
}  # fmt: skip
"""Flows for `flow.name`."""
