"""Tracers in flows: dispersion, diffusion near walls, settling layers, vortices, impaction, deposition, lift."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ecume.analysis.dispersion import deposited
from ecume.laws import brownian_motion, carrier_flows, drag, unsteady_forces, wall_drag
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation.runner import Row, below, read_table, within

RADIUS = 0.5e-6
"""The radius of diffusing particles, m."""
THERMAL = brownian_motion.thermal_energy(293.15)
SPREAD = brownian_motion.diffusivity(THERMAL, drag.stokes_friction(RADIUS, 1e-3, 1.0))
"""Diffusion coefficient of these particles, m^2/s."""
MANY = 100_000
"""The number of particles of a pulse."""
OVERDAMPED = {"integrator": "overdamped"}


def rows() -> list[Row]:
    """Compare dispersion, diffusion near walls, layers, cells, impaction, deposition, gyres and lift."""
    return [
        *slit(),
        *tube(),
        *near_a_wall(),
        *layers(),
        *cells(),
        *orbits(),
        *expelled(),
        *spirals(),
        *impaction(),
        *plates(),
        *gyres(),
        *lift(),
    ]


def frames_of(plain: dict[str, Any]) -> list[Frame]:
    """The frames of a scene of tracers."""
    return list(simulate(from_plain({"model": "tracers", "gravity": 0.0, **plain})))


def variance(time: Array, peclet: float, modes: tuple[Array, Array]) -> Array:
    """The variance along the flow over 2 D t, exact for a uniform start: 1 + sum of (U H/D)^2 c (1 - (1 - exp(-l t))/(l
    t))/l.

    Times are over H^2/D with the width H; modes = (c, l) are the shares of the variance of the velocity over U^2, and
    the decay rates over D/H^2. [aris1956].
    """
    share, rate = modes
    decay = rate * time[:, None]
    found: Array = 1.0 + peclet**2 * (share / rate * (1.0 + np.expm1(-decay) / decay)).sum(axis=1)
    return found


def slit_modes() -> tuple[Array, Array]:
    """The modes of a flow between plates: 18/(pi k)^4 and (2 pi k)^2."""
    k = np.arange(1.0, 60.0)
    return 18.0 / (math.pi * k) ** 4, (2.0 * math.pi * k) ** 2


def tube_modes() -> tuple[Array, Array]:
    """The modes of a flow in a tube, with its radius as the width: 64/b^4 and b^2, with the zeros b of J1."""
    from scipy.special import jn_zeros

    b = jn_zeros(1, 60)
    return 64.0 / b**4, b**2


INSTANTS = np.array([0.05, 0.2, 1.0])
"""Times over the width squared over D."""


def pulse_rows(name: str, frames: list[Frame], peclet: float, modes: tuple[Array, Array], unit: float) -> list[Row]:
    """Rows on the variance of a pulse at the instants; within 1 % of the exact one at the end."""
    exact, found = variance(INSTANTS, peclet, modes), []
    for time, expected in zip(INSTANTS, exact, strict=True):
        frame = min(frames, key=lambda each: abs(each.time - time * unit))
        x = frame.arrays["position"][:, 0]
        computed = float(x.var()) / (2.0 * SPREAD * frame.time)
        noise = 4.0 * math.sqrt(2.0 / len(x))
        tolerance = 0.01 if time == INSTANTS[-1] and noise > 0.01 else noise
        label = f"{name}, Pe = {peclet:g}, D t/H^2 = {time:g}: variance over 2 D t"
        found.append(within(label, computed, float(expected), tolerance * float(expected)))
    return found


def slit() -> list[Row]:
    """Compare a pulse between plates at three Peclet numbers; at the end 1 + Pe^2/210 minus the transient."""
    width, found = 1e-5, []
    unit = width**2 / SPREAD
    for peclet in (10.0, 100.0, 500.0):
        frames = frames_of({
            "duration": unit, "frame_every": 0.05 * unit, "seed": int(peclet),
            "tank": {"low": [0.0, -RADIUS], "high": [1.0, width + RADIUS], "periodic": ["x"]},
            "flow": {"name": "channel", "speed": peclet * SPREAD / width, "low": [0.0, 0.0], "high": [1.0, width]},
            "particles": [{
                "radius": RADIUS, "density": 1000.0, "count": MANY, "low": [0.5, 0.0], "high": [0.5, width]}],
            "hydrodynamics": {"brownian": True, "drag": "stokes"},
            "integration": {**OVERDAMPED, "time_step": 0.0025 * unit},
        })  # fmt: skip
        found += pulse_rows("slit", frames, peclet, slit_modes(), unit)
    modes = slit_modes()
    limit = 1.0 + 100.0**2 * float((modes[0] / modes[1]).sum())
    return [*found, within("slit: the series at long times over 1 + Pe^2/210", limit / (1.0 + 1e4 / 210.0), 1.0, 1e-6)]


SIDES = 32
"""Sides of the prism that approximates a tube."""


def tube() -> list[Row]:
    """Compare a pulse in a tube: a prism of 32 sides with the same cross-sectional area."""
    radius, peclet = 1e-5, 100.0
    unit, angle = radius**2 / SPREAD, 2.0 * math.pi * np.arange(SIDES) / SIDES
    # The surface at which centers are reflected has the cross-sectional area of the tube.
    reach = radius * math.sqrt(math.pi / (SIDES * math.tan(math.pi / SIDES))) + RADIUS
    outer = reach / math.cos(math.pi / SIDES)
    ring = [(x, outer * math.cos(a), outer * math.sin(a)) for x in (-1.0, 1.0) for a in angle]
    rng = np.random.default_rng(6)
    r, a = radius * np.sqrt(rng.uniform(0.0, 0.998**2, MANY // 2)), rng.uniform(0.0, 2.0 * math.pi, MANY // 2)
    places = np.stack([np.zeros(MANY // 2), r * np.cos(a), r * np.sin(a)], axis=1)
    frames = frames_of({
        "duration": unit, "frame_every": 0.05 * unit, "tank": {"vertices": ring},
        "flow": {"name": "tube", "speed": peclet * SPREAD / radius, "radius": radius, "center": [0.0, 0.0, 0.0]},
        "particles": [{"radius": RADIUS, "density": 1000.0, "positions": places.tolist()}],
        "hydrodynamics": {"brownian": True, "drag": "stokes"},
        "integration": {**OVERDAMPED, "time_step": 0.0025 * unit},
    })  # fmt: skip
    modes = tube_modes()
    limit = 1.0 + 100.0**2 * float((modes[0] / modes[1]).sum())
    end = within("tube: the series at long times over 1 + Pe^2/48", limit / (1.0 + 1e4 / 48.0), 1.0, 1e-6)
    return [*pulse_rows("tube", frames, peclet, modes, unit), end]


def near_a_wall() -> list[Row]:
    """Compare diffusion coefficients at three gaps with those far away, over a time in which gaps change little."""
    found, count = [], 20_000
    for ratio in (0.2, 1.0, 5.0):
        gap = ratio * RADIUS
        time = 2e-4 * gap**2 / SPREAD * max(1.0, 1.0 / ratio)
        frames = frames_of({
            "duration": time, "frame_every": time, "tank": {"high": [1e-3, 1e-3], "periodic": ["x"]},
            "hydrodynamics": {"wall_drag": True, "brownian": True, "drag": "stokes"},
            "particles": [{"radius": RADIUS, "density": 1000.0, "positions": [[5e-4, RADIUS + gap]] * count}],
            "integration": {**OVERDAMPED, "time_step": time / 4},
        })  # fmt: skip
        way = frames[-1].arrays["position"] - frames[0].arrays["position"]
        factors = (wall_drag.parallel_factor(gap, RADIUS), wall_drag.perpendicular_factor(gap, RADIUS))
        for axis, (name, factor) in enumerate(zip(("along", "toward"), factors, strict=True)):
            computed = float(way[:, axis].var()) / (2.0 * SPREAD * time)
            tolerance = 4.0 * math.sqrt(2.0 / count) / factor
            found.append(within(f"gap of {ratio:g} a: D {name} the wall over D", computed, 1.0 / factor, tolerance))
    x = 1.0 / 6.0
    series = 1.0 - 9.0 / 16.0 * x + x**3 / 8.0 - 45.0 / 256.0 * x**4 - x**5 / 16.0
    exact = 1.0 / wall_drag.parallel_factor(5.0, 1.0)
    return [*found, within("gap of 5 a: exact series along the wall, beside Faxen's", exact, series, x**6)]


LAYERS = 10


def layers() -> list[Row]:
    """Compare the numbers of settling and diffusing particles in layers of equal expected number; within 3 % down to
    contact.
    """
    count = 50_000
    weight = 4.0 / 3.0 * math.pi * RADIUS**3 * 100.0 * 9.81
    length = brownian_motion.sedimentation_length(THERMAL, weight)
    tall = 3.0 * length
    settled = tall**2 / SPREAD
    last = frames_of({
        "duration": 2.0 * settled, "frame_every": settled, "gravity": 9.81, "seed": 3,
        "tank": {"high": [tall, tall + 2.0 * RADIUS], "periodic": ["x"]},
        "particles": [{"radius": RADIUS, "density": 1100.0, "count": count}],
        "hydrodynamics": {"brownian": True, "drag": "stokes"},
        "integration": {**OVERDAMPED, "time_step": settled / 100},
    })[-1]  # fmt: skip
    edges = -length * np.log1p(np.linspace(0.0, 1.0, LAYERS + 1) * math.expm1(-3.0)) + RADIUS
    edges[-1] += RADIUS
    counts = np.histogram(last.arrays["position"][:, 1], edges)[0]
    return [
        within(
            f"barometric layer {k} of {LAYERS} from contact: number over the exact one", n * LAYERS / count, 1.0, 0.03
        )
        for k, n in enumerate(counts, 1)
    ]


def integrated(
    rates: Callable[[float, Array], list[float]], start: list[float], time: float, events: Any = None
) -> Any:
    """A path by SciPy's integrator of order 8."""
    from scipy.integrate import solve_ivp

    return solve_ivp(rates, (0.0, time), start, "DOP853", rtol=1e-11, atol=1e-14, events=events)


def cells() -> list[Row]:
    """Compare heavy particles that settle through cells, with the acceleration of the liquid: paths, and the mean
    speed.
    """
    speed, wavelength, radius, density = 0.02, 0.1, 2e-4, 1300.0
    k, time = 2.0 * math.pi / wavelength, 4.0
    displaced = 4.0 / 3.0 * math.pi * radius**3 * 1000.0
    inertia, friction = displaced * (density / 1000.0 + 0.5), drag.stokes_friction(radius, 1e-3, 1.0)
    fall = displaced * (density / 1000.0 - 1.0) * 9.81
    starts = np.random.default_rng(8).uniform(0.0, wavelength, (6, 2))

    def rates(_: float, x: Array) -> list[float]:
        a, b = k * x[0], k * x[1]
        u, w = carrier_flows.cellular_velocity(a, b, speed)
        # Du/Dt of steady cells: (u . grad) u.
        du = 0.5 * k * speed**2 * math.sin(2.0 * a)
        dw = 0.5 * k * speed**2 * math.sin(2.0 * b)
        push = [unsteady_forces.liquid_inertia(displaced, each, 0.5) for each in (du, dw)]
        return [
            x[2], x[3], (friction * (u - x[2]) + push[0]) / inertia, (friction * (w - x[3]) + push[1] - fall) / inertia,
        ]  # fmt: skip

    frames = frames_of({
        "duration": time, "frame_every": time, "gravity": 9.81, "tank": {"low": [-5.0, -5.0], "high": [5.0, 5.0]},
        "flow": {"name": "cellular", "speed": speed, "wavelength": wavelength, "center": [0.0, 0.0]},
        "particles": [{"radius": radius, "density": density, "positions": starts.tolist()}],
        "hydrodynamics": {"drag": "stokes", "fluid_acceleration": True},
        "integration": {"integrator": "inertial", "time_step": 1e-3},
    })  # fmt: skip
    ends = np.array([integrated(rates, [*start, 0.0, 0.0], time).y[:2, -1] for start in starts])
    off = float(np.abs(frames[-1].arrays["position"] - ends).max()) / wavelength
    sunk = float((starts[:, 1] - frames[-1].arrays["position"][:, 1]).mean()) / time / (fall / friction)
    exact = float((starts[:, 1] - ends[:, 1]).mean()) / time / (fall / friction)
    return [
        below("settling through cells: error of paths over the wavelength", off, 1e-3),
        within("settling through cells: mean speed over Stokes's", sunk, exact, 1e-3),
    ]


ORBITS = 900
"""Particles that start in a cell, on a square lattice."""


def suspended(shape: float, x: Array) -> Any:
    """Whether particles without inertia stay in a cell, at phases x (N, 2) in it: this holds on the closed paths around
    the point where the liquid rises at their settling speed; shape = W/U.

    Along a path sin(kx) sin(kz) + (W/U) kx is constant; the outermost closed path ends where kx = pi. [maxey1987].
    """
    return np.sin(x[:, 0]) * np.sin(x[:, 1]) > shape * (math.pi - x[:, 0])


def in_cells(ratio: float, relaxation: float, starts: Array, time: float, integration: dict[str, Any]) -> Array:
    """The distance (m) by which particles settle in cells with k = U = 1, W = `ratio` and a relaxation time, in a gas
    so light that only drag acts.
    """
    radius, density, side = 1e-3, 1e4, 2.0 * math.pi
    viscosity = 2.0 / 9.0 * density * radius**2 / relaxation
    first, last = frames_of({
        "duration": time, "frame_every": time, "gravity": ratio / relaxation,
        "liquid": {"density": 1e-3, "viscosity": viscosity},
        "tank": {"high": [side, side], "periodic": ["x", "y"]},
        "flow": {"name": "cellular", "speed": 1.0, "wavelength": side, "center": [0.0, 0.0]},
        "particles": [{"radius": radius, "density": density, "positions": starts.tolist()}],
        "hydrodynamics": {"drag": "stokes", "added_mass": False}, "integration": integration,
    })  # fmt: skip
    fallen: Array = first.arrays["position"][:, 1] - last.arrays["position"][:, 1] - side * last.arrays["image"][:, 1]
    return fallen


def orbits() -> list[Row]:
    """Compare the particles without inertia that stay suspended in cells, and their share of the area."""
    from scipy.integrate import quad

    steps, found = math.isqrt(ORBITS), []
    phase = (np.arange(steps) + 0.5) * math.pi / steps
    starts = np.stack(np.meshgrid(phase, phase), axis=-1).reshape(-1, 2)
    for ratio in (0.25, 0.5, 0.75):
        fallen = in_cells(ratio, 0.05, starts, 100.0, {**OVERDAMPED, "time_step": 0.05})
        stays = np.asarray(fallen < 2.0 * math.pi)
        exact = suspended(ratio, starts)
        label = f"cells, W/U = {ratio:g}, no inertia"
        found.append(within(f"{label}: fraction on the side of the outermost orbit that it starts on",
                            float((stays == exact).mean()), 1.0, 0.0))  # fmt: skip

        def height(x: float, ratio: float = ratio) -> float:
            return math.pi - 2.0 * math.asin(min(1.0, ratio * (math.pi - x) / math.sin(x)))

        area = quad(height, 0.0, math.pi, limit=200)[0] / math.pi**2
        found.append(within(f"{label}: fraction that stays suspended", float(stays.mean()), area, 1.0 / steps))
    return found


def expelled() -> list[Row]:
    """Compare heavy particles with inertia in the same cells: all settle, along few paths, faster than in liquid at
    rest.
    """
    ratio, relaxation, time, found = 0.5, 0.2, 100.0, []
    starts = np.random.default_rng(4).uniform(0.0, 2.0 * math.pi, (400, 2))

    def rates(_: float, x: Array) -> list[float]:
        u, w = carrier_flows.cellular_velocity(x[0], x[1], 1.0)
        return [x[2], x[3], (u - x[2]) / relaxation, (w - ratio - x[3]) / relaxation]

    fallen = in_cells(ratio, relaxation, starts, time, {"integrator": "inertial", "time_step": 0.01})
    label = f"cells, W/U = {ratio:g}, k U tau = {relaxation:g}"
    found.append(within(f"{label}: fraction that stays suspended", float((fallen < 2.0 * math.pi).mean()), 0.0, 0.0))
    few = starts[:6]
    exact = np.array([start[1] - integrated(rates, [*start, 0.0, 0.0], time).y[1, -1] for start in few]) / time / ratio
    speed = fallen / time / ratio
    found.append(within(f"{label}: mean speed of {len(few)} over W, in time", float(speed[: len(few)].mean()),
                        float(exact.mean()), 2e-3))  # fmt: skip
    found.append(below(f"{label}: W over the mean speed of all", 1.0 / float(speed.mean()), 1.0))
    return found


def spirals() -> list[Row]:
    """Compare the rates at which particles leave or approach their equilibrium in a cell with the eigenvalues of the
    linear equation of motion: heavy ones leave it, light ones are trapped.
    """
    return [spiral(density) for density in (2000.0, 1050.0, 500.0)]


def spiral(density: float) -> Row:
    """Compare the rate of growth of the distance from equilibrium for a density, in water, with k = U = 1, |W| = 0.5
    and a relaxation time of 0.2.
    """
    from scipy.optimize import fsolve

    radius, pull, side = 1e-3, 5.0, 2.0 * math.pi
    displaced = 4.0 / 3.0 * math.pi * radius**3 * 1000.0
    inertia = displaced * (density / 1000.0 + 0.5)
    viscosity = pull * inertia / drag.stokes_friction(radius, 1.0, 1.0)
    gravity = 0.5 * pull * inertia / (displaced * abs(density / 1000.0 - 1.0))
    weight = displaced * (density / 1000.0 - 1.0) * gravity

    def acceleration(x: Array, v: Array) -> Array:
        u = np.array(carrier_flows.cellular_velocity(x[0], x[1], 1.0))
        du = 0.5 * np.sin(2.0 * x)
        push = np.array([unsteady_forces.liquid_inertia(displaced, each, 0.5) for each in du])
        found: Array = pull * (u - v) + (push - [0.0, weight]) / inertia
        return found

    still = np.zeros(2)

    def pull_at(x: Array) -> Array:
        return acceleration(x, still)

    sink = math.copysign(0.5, weight)
    rest = fsolve(pull_at, [math.acos(-sink), 0.5 * math.pi], xtol=1e-13)
    shifts = 1e-5 * np.eye(2)
    slopes = np.stack([(pull_at(rest + d) - pull_at(rest - d)) / 2e-5 for d in shifts], axis=1)
    linear = np.block([[np.zeros((2, 2)), np.eye(2)], [slopes, -pull * np.eye(2)]])
    slowest = max(np.linalg.eigvals(linear), key=lambda value: float(value.real))
    period = 2.0 * math.pi / abs(slowest.imag)
    frames = frames_of({
        "duration": 3.0 * period, "frame_every": period, "gravity": gravity, "liquid": {"density": 1000.0,
        "viscosity": viscosity}, "tank": {"high": [side, side], "periodic": ["x", "y"]},
        "flow": {"name": "cellular", "speed": 1.0, "wavelength": side, "center": [0.0, 0.0]},
        "particles": [{"radius": radius, "density": density, "positions": [(rest + np.array([1e-3, 0.0])).tolist()]}],
        "hydrodynamics": {"drag": "stokes", "fluid_acceleration": True},
        "integration": {"integrator": "inertial", "time_step": period / 1500},
    })  # fmt: skip
    away = [float(np.linalg.norm(frame.arrays["position"][0] - rest)) for frame in frames]
    label = f"cells: growth rate of the distance from equilibrium, density {density / 1000.0:g} of the liquid's"
    exact = float(slowest.real)
    return within(label, math.log(away[3] / away[1]) / (2.0 * period), exact, 0.01 * abs(exact))


FAR = -60.0
"""Radii: where particles start before a cylinder, with the velocity of the stream there."""
READING = 0.02
"""Of the efficiency: how far the published integrations, by machine in 1946, may be off."""


def grazing(stokes: float, start: float) -> float:
    """The height (radii) at x = `start` radii of the highest path that touches a cylinder, by bisection."""

    def rates(_: float, x: Array) -> list[float]:
        u, _, w = carrier_flows.ideal_flow_past_cylinder((x[0], 0.0, x[1]), 1.0, (1.0, 0.0, 0.0))
        return [x[2], x[3], (u - x[2]) / stokes, (w - x[3]) / stokes]

    def touches(_: float, x: Array) -> float:
        return float(math.hypot(x[0], x[1]) - 1.0)

    touches.terminal = True  # type: ignore[attr-defined]  # SciPy reads it
    low, high = 0.0, 1.0
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        u, _, w = carrier_flows.ideal_flow_past_cylinder((start, 0.0, middle), 1.0, (1.0, 0.0, 0.0))
        path = integrated(rates, [start, middle, u, w], 2.0 - start, touches)
        low, high = (middle, high) if len(path.t_events[0]) else (low, middle)
    return low


def held_by_a_cylinder(stokes: float, count: int) -> float:
    """The share of particles, within the radius ahead of a cylinder in ideal flow, that the cylinder collects."""
    size, speed, viscosity = 1e-3, 1.0, 1e-3
    radius, time = 1e-5 * size, (2.0 - FAR) * size / speed
    # Pointlike particles, whose density determines the Stokes number.
    density = stokes * size / speed * drag.stokes_friction(radius, viscosity, 1.0) / (4.0 / 3.0 * math.pi * radius**3)
    heights = ((np.arange(count) + 0.5) / count * size).tolist()
    velocities = [
        carrier_flows.ideal_flow_past_cylinder((FAR * size, 0.0, y), size, (speed, 0.0, 0.0))[::2] for y in heights
    ]
    frames = frames_of({
        "duration": time, "frame_every": time,
        "liquid": {"density": 1e-3, "viscosity": viscosity * 1e4 / density},
        "flow": {"velocity": [speed, 0.0], "around_obstacles": "ideal"},
        "obstacles": [{"center": [0.0, 0.0], "radius": size, "sticking": True}],
        "particles": [{
            "radius": radius, "density": 1e4, "positions": [[FAR * size, y] for y in heights], "velocities": velocities,
        }],
        "hydrodynamics": {"drag": "stokes", "added_mass": False},
        "integration": {"integrator": "inertial", "time_step": 0.002 * size / speed},
    })  # fmt: skip
    return float(deposited(frames[-1]).mean())


def impaction() -> list[Row]:
    """Compare the efficiency of a cylinder in ideal flow over the Stokes number, m U/(friction R), with DOP853 and
    with the curve of Langmuir and Blodgett.
    """
    count = 200
    small = held_by_a_cylinder(0.12, count)
    found = [below("impaction, Stk = 0.12: efficiency below Stk = 1/8", small, 0.5 / count + 1e-9)]
    for case in read_table("tracers_flows", "published"):
        stokes, held = float(case["stokes_number"]), held_by_a_cylinder(float(case["stokes_number"]), count)
        label = f"impaction, Stk = {stokes:g}: efficiency of a cylinder"
        found.append(within(label, held, grazing(stokes, FAR), 1.5 / count))
        found.append(within(f"{label} ({case['source']})", held, float(case["efficiency"]), READING))
    return found


def plates() -> list[Row]:
    """Compare the deposition from plug flow between two sticking plates, over the distance."""
    count, width = 50_000, 1e-5
    unit = width**2 / SPREAD
    speed = 100.0 * width / unit
    frames = frames_of({
        "duration": 0.3 * unit, "frame_every": 0.3 * unit, "seed": 2, "flow": {"velocity": [speed, 0.0]},
        "tank": {"low": [-1.0, 0.0], "high": [1.0, width + 2.0 * RADIUS], "walls": [
            {"wall": 1, "sticking": True}, {"wall": 3, "sticking": True}]},
        "particles": [{"radius": RADIUS, "density": 1000.0, "count": count, "low": [0.0, RADIUS],
                       "high": [0.0, width + RADIUS]}],
        "hydrodynamics": {"brownian": True, "drag": "stokes"},
        "integration": {**OVERDAMPED, "time_step": 0.0005 * unit},
    })  # fmt: skip
    last, n = frames[-1], np.arange(1.0, 200.0, 2.0) * math.pi
    where, held = last.arrays["position"][:, 0], deposited(last)
    found = []
    for time in (0.02, 0.1, 0.25):
        passing = float((8.0 / n**2 * np.exp(-(n**2) * time)).sum())
        computed = 1.0 - float((held & (where < speed * time * unit)).mean())
        noise = 4.0 * math.sqrt(passing * (1.0 - passing) / count) + 0.002
        found.append(within(f"plates, x D/(U H^2) = {time:g}: fraction not yet deposited", computed, passing, noise))
    return found


def gyres() -> list[Row]:
    """Compare paths in two gyres with an oscillating border, over one and a half periods."""
    amplitude, swing, time = 0.1, 0.25, 15.0
    starts = np.random.default_rng(9).uniform((0.05, 0.05), (1.95, 0.95), (20, 2))

    def rates(t: float, x: Array) -> list[float]:
        now = swing * math.sin(2.0 * math.pi * t / 10.0)
        return list(carrier_flows.double_gyre_velocity(x[0], x[1], now, math.pi * amplitude))

    frames = frames_of({
        "duration": time, "frame_every": time, "tank": {"high": [2.0, 1.0]},
        "flow": {"name": "double-gyre", "speed": math.pi * amplitude, "swing": swing, "period": 10.0},
        "particles": [{"radius": 1e-6, "density": 1000.0, "positions": starts.tolist()}],
        "integration": {**OVERDAMPED, "time_step": 0.005},
    })  # fmt: skip
    ends = np.array([integrated(rates, list(start), time).y[:, -1] for start in starts])
    off = float(np.abs(frames[-1].arrays["position"] - ends).max())
    return [below("double gyre: error of paths after 15 s (m)", off, 1e-9)]


def lift() -> list[Row]:
    """Compare the lateral motion of a particle that settles through sheared liquid."""
    shear, radius, time = 0.5, 2e-4, 0.4
    displaced = 4.0 / 3.0 * math.pi * radius**3 * 1000.0
    inertia, friction = displaced * 1.52, drag.stokes_friction(radius, 1e-3, 1.0)
    strength = unsteady_forces.saffman_lift(1.0, radius, 1000.0, 1e-3, shear)

    def rates(_: float, x: Array) -> list[float]:
        slip = (shear * x[1] - x[2], -x[3])
        # (u - v) x curl u, and curl u = +shear about y (x to z): along x it is -slip_z, along z slip_x.
        force = (friction * slip[0] - strength * slip[1], friction * slip[1] + strength * slip[0])
        return [x[2], x[3], force[0] / inertia, (force[1] - displaced * 0.02 * 9.81) / inertia]

    ends = []
    for given in (True, False):
        frames = frames_of({
            "duration": time, "frame_every": time, "gravity": 9.81, "flow": {"shear_rate": shear},
            "tank": {"high": [0.2, 0.1]}, "particles": [
                {"radius": radius, "density": 1020.0, "positions": [[0.05, 0.08]]}],
            "hydrodynamics": {"drag": "stokes", "lift": given},
            "integration": {"integrator": "inertial", "time_step": 5e-4},
        })  # fmt: skip
        ends.append(frames[-1].arrays["position"][0])
    exact = integrated(rates, [0.05, 0.08, 0.0, 0.0], time).y[:2, -1]
    drift = float(ends[0][0] - ends[1][0])
    return [
        within(
            "Saffman's lift: displacement across the shear (m)", drift, float(exact[0] - ends[1][0]), 1e-3 * abs(drift)
        )
    ]
