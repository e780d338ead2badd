"""The flow around the obstacles of a scene: an exact solution, or one that is computed at the start."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ecume.errors import BadInput, Fault, SceneError
from ecume.models.tracers.named_flows import DETOURS, PastObstacle
from ecume.models.tracers.obstacle_flows import channel_flow, disc_outline
from ecume.models.tracers.obstacle_flows_3d import Corners, Inflow, Sphere, solid_flow
from ecume.scenes.tracers import FlowSpec, ObstacleSpec, TracersScene

Box = tuple[tuple[float, ...], tuple[float, ...]]
PATH = "flow.around_obstacles"


def detour_of(scene: TracersScene, stream: tuple[float, float, float]) -> tuple[Any, Box]:
    """The exact solution around the obstacle, and the box in which it varies. Raises SceneError without one."""
    kind, d, bodies = scene.flow.around_obstacles, scene.dimensions, scene.obstacles
    if (kind, d) not in DETOURS:
        message = "got 'creeping' in 2D: no slow stream goes around a disc (Stokes's paradox); expected 'ideal', or 3D"
        raise SceneError([Fault(PATH, message)])
    if len(bodies) != 1 or bodies[0].center is None or bodies[0].radius is None or scene.tank is not None:
        message = "there is an exact solution for one disc or sphere without a tank only; "
        message += "use a creeping flow in a channel or duct, or flow.field, for others"
        raise SceneError([Fault(PATH, message)])
    center, radius = bodies[0].center, bodies[0].radius
    box = (tuple(each - 3.0 * radius for each in center), tuple(each + 3.0 * radius for each in center))
    along = stream if d == 3 else (stream[0], 0.0, stream[1])
    return PastObstacle(deep(center), radius, along, list(DETOURS).index((kind, d))), box


def around_in_channel(scene: TracersScene) -> Any:
    """The computed flow of a channel around obstacles. Raises SceneError if the flow cannot be computed."""
    flow, tank = scene.flow, scene.tank
    require_unused(flow, frozenset({"speed", "pulse"}), "a channel with obstacles")
    if tank is None or tank.high is None or tank.low is None:
        raise SceneError([Fault(PATH, "a creeping flow goes between the sides of a box; use flow.field for others")])
    if flow.speed is None:
        raise SceneError([Fault("flow.speed", f"is missing; the flow {flow.name} needs it")])
    if flow.velocity is not None or flow.shear_rate:
        raise SceneError([Fault(PATH, "got flow.velocity or shear_rate beside a channel; they would cross obstacles")])
    if not scene.obstacles:
        raise SceneError([Fault(PATH, "got no obstacles; remove it, or add [[obstacles]]")])
    try:
        way = _in_2d if scene.dimensions == 2 else _in_3d
        return way(scene, (tank.low, tank.high), tuple(tank.periodic), float(flow.speed))
    except BadInput as error:
        raise SceneError([Fault(PATH, str(error.args[0]))]) from error


def _in_2d(scene: TracersScene, box: Box, periodic: tuple[str, ...], speed: float) -> Any:
    if scene.flow.name != "channel":
        raise SceneError([Fault("flow.name", f"got {scene.flow.name!r} in 2D; expected channel, or a scene in 3D")])
    if "y" in periodic:
        message = "got y beside a flow around obstacles in a channel; expected x alone"
        raise SceneError([Fault("tank.periodic", message)])
    outlines = tuple(_outline(body) for body in scene.obstacles)
    low, high = box
    return channel_flow((low[0], low[1]), (high[0], high[1]), outlines, speed, periodic="x" in periodic)


def _in_3d(scene: TracersScene, box: Box, periodic: tuple[str, ...], speed: float) -> Any:
    inflow: Inflow = "channel" if scene.flow.name == "channel" else "duct"
    across = {"channel": ["y"], "duct": []}[inflow]
    if [axis for axis in ("y", "z") if axis in periodic] != across:
        message = "the flow channel in 3D is periodic along y (and x), between plates; duct has four walls, and may be "
        raise SceneError([Fault("tank.periodic", message + "periodic along x")])
    bodies = tuple(_solid(body) for body in scene.obstacles)
    repeated = ("x" in periodic, "y" in periodic, False)
    return solid_flow(deep(box[0]), deep(box[1]), bodies, speed, inflow, repeated)


def _outline(body: ObstacleSpec) -> tuple[tuple[float, float], ...]:
    """The corners of an obstacle in 2D; for a disc, those of a circumscribed polygon."""
    if body.center is not None and body.radius is not None:
        return disc_outline(body.center, body.radius)
    if body.low is not None and body.high is not None:
        (a, b), (c, d) = body.low, body.high
        return (a, b), (c, b), (c, d), (a, d)
    return tuple((corner[0], corner[1]) for corner in body.vertices)


def _solid(body: ObstacleSpec) -> Sphere | Corners:
    """An obstacle in 3D: center and radius of a sphere, or corners."""
    if body.center is not None and body.radius is not None:
        return deep(body.center), float(body.radius)
    if body.low is not None and body.high is not None:
        low, high = body.low, body.high
        return tuple((x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2]))
    return tuple(deep(corner) for corner in body.vertices)


def deep(point: Sequence[float]) -> tuple[float, float, float]:
    """The point with three coordinates; in 2D y is 0."""
    return (point[0], 0.0, point[1]) if len(point) == 2 else (point[0], point[1], point[2])


SHAPE_KEYS = ("speed", "rate", "wavelength", "period", "swing", "radius", "center", "low", "high", "pulse")


def require_unused(flow: FlowSpec, used: frozenset[str], what: str) -> None:
    """Raise SceneError for keys that a flow does not use."""
    spare = [key for key in SHAPE_KEYS if key not in used and getattr(flow, key) is not None]
    if spare:
        raise SceneError([Fault(f"flow.{key}", f"is not used by {what}; remove it") for key in spare])
