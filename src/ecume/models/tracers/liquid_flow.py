"""The flow of the liquid in a scene: its choice, its velocity at any position, and its scales of variation."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ecume.errors import BadInput, Fault, SceneError
from ecume.models import field_files, gridded_flows
from ecume.models.tracers.around_obstacles import around_in_channel, deep, detour_of, require_unused
from ecume.models.tracers.flow_loops import Current, Loops, loops_for
from ecume.models.tracers.named_flows import NAMED_FLOWS, Request, Still
from ecume.models.tracers.tank import bounds, periodic_of
from ecume.scenes.faults import suggestion
from ecume.scenes.tracers import FlowSpec, TracersScene
from ecume.units import Array

Corners = tuple[tuple[float, ...], tuple[float, ...]]

SAMPLES = 1000
"""The number of points at which a flow is sampled."""
INSTANTS = 8
"""The number of instants at which a flow is sampled."""
ACCURATE = 0.1
"""The longest Runge-Kutta step, over the shortest time in which the velocity along a path changes."""
NARROW = 0.1
"""The longest random displacement of a step, over the length in which the velocity changes."""
DIFFERENCE = 1e-4
"""The step of finite differences, over the shortest length of the flow: a side of the box, a wavelength or a radius."""
MOMENT = 1e-6
"""The step of finite differences in time, over the duration."""


class FlowScales(NamedTuple):
    """The scales of variation of the liquid's velocity, from samples in the box around the tank."""

    speed: float
    """m/s, the largest"""
    rate: float
    """1/s, the largest gradient, or rate of change in time"""
    length: float
    """m, the length over which the velocity changes by its own magnitude; infinite in a uniform flow"""

    def longest_step(self) -> float:
        """The longest time step along curved paths (s)."""
        return ACCURATE / self.rate if self.rate > 0.0 else math.inf

    def longest_diffusion(self, diffusivity: float) -> float:
        """The longest time step of particles that diffuse (s)."""
        return 0.5 * (NARROW * self.length) ** 2 / diffusivity


UNIFORM = FlowScales(0.0, 0.0, math.inf)


class LiquidFlow(NamedTuple):
    """The whole flow of a scene."""

    uniform: Array
    """(3,) m/s"""
    shear_rate: float
    current: Any = ()
    loops: Loops | None = None
    scales: FlowScales = UNIFORM
    removed: float = 0.0
    """the divergence that the interpolation removes, over the fluxes in a file"""

    def velocity(self, places: Array, time: float | Array) -> Array:
        """The velocity (n, d) in m/s at places, at one time or at a separate time for each place."""
        found = np.tile(self.uniform[: places.shape[1]], (len(places), 1))
        found[:, 0] += self.shear_rate * places[:, -1]
        if self.loops is not None:
            loop = self.loops.velocities_then if isinstance(time, np.ndarray) else self.loops.velocities
            loop(np.ascontiguousarray(places), time, self.current, found)
        return found

    def unbounded(self) -> LiquidFlow:
        """The same flow without periodic continuation beyond a periodic tank."""
        if self.current == ():
            return self
        return self._replace(current=self.current._replace(periods=(0.0,) * len(self.current.periods)))

    def instants(self, duration: float) -> list[float]:
        """The times (s) at which the flow is sampled."""
        return [0.0] if self.steady else [duration * k / INSTANTS for k in range(INSTANTS)]

    @property
    def steady(self) -> bool:
        """Whether the flow is the same at all times."""
        if self.current == ():
            return True
        shape = self.current.shape
        turning = getattr(shape, "turning", 0.0) or len(getattr(shape, "times", (0,))) > 1
        return not turning and self.current.pulse == (0.0, 0.0, 0.0) and not isinstance(shape, OwnShape)


class OwnShape(NamedTuple):
    """The constants of a user-defined flow."""

    constants: tuple[float, ...]


class OwnFlow(NamedTuple):
    """A user-defined flow."""

    loops: Loops
    constants: tuple[float, ...]


def varying_flow(scene: TracersScene, box: Corners, own: OwnFlow | None = None) -> LiquidFlow:
    """The flow of a scene; `box`: the corners of its tank. Raises SceneError."""
    flow, d = scene.flow, scene.dimensions
    given, removed = (*(flow.velocity or ()), 0.0, 0.0, 0.0), 0.0
    uniform = (given[0], given[1], given[2])
    plain = LiquidFlow(np.array(uniform), flow.shear_rate)
    shapes = [name for name, given in (("name", flow.name), ("field", flow.field), ("user_laws", own)) if given]
    if len(shapes) > 1:
        raise SceneError([Fault(f"flow.{shapes[0]}", f"got it beside {shapes[1]}; expected one flow")])
    forces = scene.hydrodynamics
    forced = forces.fluid_acceleration or forces.faxen or forces.lift or forces.wall_drag or flow.turbulence is not None
    in_channel = flow.around_obstacles == "creeping" and shapes == ["name"] and flow.name in ("channel", "duct")
    if flow.around_obstacles != "none" and not in_channel and (shapes or flow.shear_rate or not any(uniform)):
        message = "needs a uniform flow.velocity and no other flow beside it, or a creeping flow in a channel or duct"
        raise SceneError([Fault("flow.around_obstacles", message)])
    shape: Any
    if in_channel:
        shape = around_in_channel(scene)
    elif flow.around_obstacles != "none":
        require_unused(flow, frozenset(), "a flow around an obstacle")
        shape, box = detour_of(scene, (uniform[0], uniform[1], uniform[2]))
    elif not shapes:
        require_unused(flow, frozenset(), "a uniform flow")
        if not forced:
            return plain
        shape = Still(0.0)
    elif own is not None:
        shape = OwnShape(own.constants)
        require_unused(flow, frozenset({"pulse"}), "a flow by a function")
    elif flow.field is not None:
        require_unused(flow, frozenset({"pulse"}), "a field")
        shape, removed = _shape_of_field(scene)
    else:
        shape = _named_shape(scene, box)
    pulse = flow.pulse
    turning = 2.0 * math.pi / pulse.period if pulse is not None and pulse.period else 0.0
    factor = (0.0, 0.0, 0.0) if pulse is None else (float(pulse.amplitude), turning, float(pulse.decay_rate))
    steps = getattr(getattr(shape, "bins", shape), "step", None)
    spacing = 0.1 * min(steps) if steps else DIFFERENCE * _shortest_length(flow, box)
    periodic = periodic_of(scene)
    tank = (periodic.low[:d], periodic.sides[:d])
    current = Current(shape, factor, (*uniform, flow.shear_rate), spacing, *tank)
    loops = own.loops if own is not None else loops_for(current, d)
    made = LiquidFlow(plain.uniform, flow.shear_rate, current, loops, UNIFORM, removed)
    return made._replace(scales=_scales(made, box, scene.duration, spacing))


def _shortest_length(flow: FlowSpec, box: Corners) -> float:
    """The shortest length over which a named flow may vary (m)."""
    corners = (flow.low or box[0], flow.high or box[1])
    sides = [b - a for a, b in (*zip(*box, strict=True), *zip(*corners, strict=True))]
    return min(*sides, *(each for each in (flow.wavelength, flow.radius) if each is not None))


def _shape_of_field(scene: TracersScene) -> tuple[Any, float]:
    assert scene.flow.field is not None  # noqa: S101  # the caller looked
    try:
        grid = field_files.grid_of(scene.flow.field, scene.dimensions)
    except BadInput as error:
        key = error.args[1] if len(error.args) > 1 else "file"
        raise SceneError([Fault(f"flow.field.{key}", str(error.args[0]))]) from error
    _require_overlap(scene, grid)
    fit = gridded_flows.fitted(grid, scene.flow.field.interpolation, _wrapped(scene, grid))
    return fit.shape, fit.removed


def _require_overlap(scene: TracersScene, grid: gridded_flows.Grid) -> None:
    """Raise SceneError for a grid that has no part in common with the tank."""
    if scene.tank is None:
        return
    for axis, (low, high) in enumerate(zip(*bounds(scene), strict=True)):
        left, nodes = grid.low[axis], grid.velocity.shape[1 + axis]
        right = left + grid.step[axis] * (nodes - 1)
        if left >= high or right <= low:
            way = "xyz"[axis] if scene.dimensions == 3 else "xy"[axis]
            message = (
                f"its grid reaches from {left:g} m to {right:g} m along {way}, the tank from {low:g} m to {high:g} m"
            )
            raise SceneError([Fault("flow.field.file", f"{message}; shift the tank, or set length_unit")])


def _wrapped(scene: TracersScene, grid: gridded_flows.Grid) -> tuple[int, ...]:
    """The axes along which the flow of a grid continues periodically: the tank has its period, and the velocities at
    both ends are equal.
    """
    found, periodic, (low, _) = [], periodic_of(scene).sides, bounds(scene)
    for axis, step in enumerate(grid.step):
        nodes = grid.velocity.shape[1 + axis]
        ends = np.take(grid.velocity, [0, nodes - 1], axis=1 + axis)
        first, last = np.split(ends, 2, axis=1 + axis)
        alike = np.allclose(first, last, rtol=0.0, atol=1e-9 * float(np.nanmax(np.abs(grid.velocity))), equal_nan=True)
        fits = abs((nodes - 1) * step - periodic[axis]) < 1e-6 * step and abs(grid.low[axis] - low[axis]) < 1e-6 * step
        if periodic[axis] > 0.0 and fits and alike and nodes > gridded_flows.SPARE + 1:
            found.append(axis)
    return tuple(found)


def _named_shape(scene: TracersScene, box: Corners) -> Any:
    flow, d = scene.flow, scene.dimensions
    if flow.name not in NAMED_FLOWS:
        raise SceneError([Fault("flow.name", f"got {flow.name!r}; {suggestion(flow.name, NAMED_FLOWS)}")])
    row = NAMED_FLOWS[flow.name]
    if d not in row.dimensions:
        raise SceneError([Fault("flow.name", f"got {flow.name!r} in {d}D; expected a scene in {row.dimensions[0]}D")])
    require_unused(flow, row.keys | {"pulse"}, f"the flow {flow.name}")
    if row.needs_box and scene.tank is None and (flow.low is None or flow.high is None):
        raise SceneError([Fault("flow.high", f"is missing; the flow {flow.name} needs a tank, or low and high")])
    low, high = flow.low or box[0], flow.high or box[1]
    if any(b <= a for a, b in zip(low, high, strict=True)):
        raise SceneError([Fault("flow.high", "expected a corner above low in each direction")])
    middle = flow.center or tuple(0.5 * (a + b) for a, b in zip(low, high, strict=True))
    request = Request(flow, (deep(low), deep(high)), deep(middle), d, scene.gravity)
    try:
        return row.shape(request)
    except BadInput as error:
        raise SceneError([Fault(f"flow.{error.args[1]}", str(error.args[0]))]) from error


def _scales(flow: LiquidFlow, box: Corners, duration: float, spacing: float) -> FlowScales:
    """Speed, gradient and length of a flow in a box, from samples."""
    low, high = (np.array(corner, float) for corner in box)
    points = low + _even_points(SAMPLES, len(low)) * (high - low)
    speed, rate, change, growth = 0.0, 0.0, 0.0, 0.0
    for time in flow.instants(duration):
        here = flow.velocity(points, time)
        if not np.isfinite(here).all():
            i = int(np.flatnonzero(~np.isfinite(here).all(axis=1))[0])
            where = ", ".join(f"{value:g}" for value in points[i])
            raise SceneError([Fault("flow", f"got no finite velocity at ({where}) m and {time:g} s")])
        speed = max(speed, float(np.sqrt((here**2).sum(axis=1)).max()))
        for axis in range(len(low)):
            moved = points.copy()
            moved[:, axis] += spacing
            slope = np.sqrt(((flow.velocity(moved, time) - here) ** 2).sum(axis=1)) / spacing
            rate = max(rate, float(slope.max()))
        change = max(change, _rate_in_time(flow))
        if isinstance(flow.current.shape, OwnShape):
            late = flow.velocity(points, time + MOMENT * duration) - here
            growth = max(growth, float(np.sqrt((late**2).sum(axis=1)).max()) / (MOMENT * duration))
    change = max(change, growth / speed if speed > 0.0 else 0.0)
    length = speed / rate if rate > 0.0 else math.inf
    return FlowScales(speed, max(rate, change), length)


def _rate_in_time(flow: LiquidFlow) -> float:
    """The largest rate of change in time (1/s), from the periods of a flow and the instants of a file."""
    current = flow.current
    rates: list[float] = [getattr(current.shape, "turning", 0.0), current.pulse[1], current.pulse[2]]
    times = getattr(current.shape, "times", np.zeros(1))
    if len(times) > 1:
        rates.append(0.5 / float(np.diff(times).min()))
    return max(rates)


def _even_points(count: int, dimensions: int) -> Array:
    """(n, d) points spread evenly in the unit box: Halton's sequence."""
    found = np.zeros((count, dimensions))
    for axis, base in enumerate((2, 3, 5)[:dimensions]):
        rest, scale = np.arange(1, count + 1), 1.0 / base
        while rest.any():
            found[:, axis] += scale * (rest % base)
            rest, scale = rest // base, scale / base
    return found


def own_velocity(law: Callable[..., Any], dimensions: int) -> Callable[..., Any]:
    """The velocity function for `flow_loops` of a user law, law(position, time, constants)."""
    from ecume.models.user_laws import compiled_for_laws

    function = compiled_for_laws(law)

    @compiled_for_laws
    def in_2d(shape: OwnShape, x: float, y: float, z: float, time: float) -> tuple[float, float, float]:
        found = function((x, z), time, shape.constants)
        return found[0], 0.0, found[1]

    @compiled_for_laws
    def in_3d(shape: OwnShape, x: float, y: float, z: float, time: float) -> tuple[float, float, float]:
        found = function((x, y, z), time, shape.constants)
        return found[0], found[1], found[2]

    return in_2d if dimensions == 2 else in_3d
