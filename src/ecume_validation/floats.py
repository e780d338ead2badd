"""Floats whose motion is also integrated by SciPy, and a raft: the cases `meeting`, `walls`, `integrators` and `raft`.

The first part is the reference: the force laws of the runs with an independent integration. Charge and friction of a
float are from ecume's laws, which the case `floating` and the tests verify. Bessel functions and the integration of the
motion are from SciPy, and the amplitude at the wall is computed here.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import i1, k1

from ecume.errors import Diverged
from ecume.laws import flotation, immersion
from ecume.laws.capillarity import pair_strength
from ecume.models import MODELS
from ecume.models.floating.time_integration.step_size import StepWarning
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array
from ecume_validation.runner import Row, above, below, case_scene, floating_scene, frames_of, within

ACCURACY = 1e-12
"""The relative accuracy of the reference."""
LONGEST = 1e4
"""The longest integration (s); all events come earlier."""


class Body(NamedTuple):
    """A float as a point with a capillary charge, a mass and a friction."""

    radius: float
    mass: float
    charge: float
    friction: float


def bodies_of(scene: FloatingScene) -> list[Body]:
    """A body for each table of floats of the scene, with drag if the scene has it."""
    liquid, bodies = liquid_of(scene), []
    for given in scene.particles:
        assert isinstance(given.contact_angle, float)  # noqa: S101  # the cases' scenes have numbers
        sphere = flotation.Sphere(given.radius, given.density, given.contact_angle)
        balance = flotation.equilibrium(sphere, liquid)
        factor = float(immersion.factor_at_filling(balance.filling_angle))
        friction = 6.0 * math.pi * liquid.viscosity * given.radius * factor if scene.hydrodynamics.resists else 0.0
        mass = given.density * 4.0 / 3.0 * math.pi * given.radius**3
        bodies.append(Body(given.radius, mass, balance.charge, friction))
    return bodies


def meeting_time(bodies: Sequence[Body], distance: float, liquid: flotation.Liquid) -> float:
    """The time (s) at which two bodies touch that are released at rest, with this distance of their centers."""
    one, other = bodies
    length, tension = liquid.capillary_length, liquid.surface_tension
    strength = 2.0 * math.pi * tension * one.charge * other.charge / length

    def rate(_: float, y: Array) -> list[float]:
        pull = strength * float(k1((y[1] - y[0]) / length))
        return [y[2], y[3], (pull - one.friction * y[2]) / one.mass, (-pull - other.friction * y[3]) / other.mass]

    def gap(_: float, y: Array) -> float:
        return float(y[1] - y[0]) - one.radius - other.radius

    gap.terminal = True  # type: ignore[attr-defined]  # SciPy's way to stop there
    start = [0.0, distance, 0.0, 0.0]
    found: Any = solve_ivp(rate, (0.0, LONGEST), start, "DOP853", events=gap, rtol=ACCURACY, atol=1e-14)
    return float(found.t_events[0][0])


class Bowl(NamedTuple):
    """A round dish and its liquid."""

    radius: float
    contact_angle: float
    liquid: flotation.Liquid


def place_in_bowl(body: Body, start: float, time: float, bowl: Bowl) -> float:
    """The distance from the axis of a body that was released at rest at the distance `start` (m)."""
    return float(_way_in_bowl(body, start, time, bowl).y[0, -1])


def time_in_bowl(body: Body, start: float, way: float, bowl: Bowl) -> float:
    """The time after which a body released at rest at the distance `start` has moved by `way` (s)."""

    def gone(_: float, y: Array) -> float:
        return abs(float(y[0]) - start) - way

    gone.terminal = True  # type: ignore[attr-defined]  # SciPy's way to stop there
    return float(_way_in_bowl(body, start, LONGEST, bowl, gone).t_events[0][0])


def _way_in_bowl(body: Body, start: float, time: float, bowl: Bowl, event: Any = None) -> Any:
    """Integrate the motion in the meniscus A_w I0(r/L) / I1(a/L), with the amplitude of the exact plane meniscus."""
    length, tension = bowl.liquid.capillary_length, bowl.liquid.surface_tension
    amplitude = length * _amplitude_over_length(bowl.contact_angle)
    strength = 2.0 * math.pi * tension * body.charge * amplitude / length / float(i1(bowl.radius / length))

    def rate(_: float, y: Array) -> list[float]:
        return [y[1], (-strength * float(i1(y[0] / length)) - body.friction * y[1]) / body.mass]

    return solve_ivp(
        rate, (0.0, time), [start, 0.0], "DOP853", events=event, rtol=ACCURACY, atol=1e-4 * ACCURACY * start
    )


def _amplitude_over_length(contact_angle: float) -> float:
    """The tail of the exact plane profile x = arcosh(2/h) - arcosh(2/h0) + sqrt(4 - h0^2) - sqrt(4 - h^2), where
    arcosh(2/h) becomes ln(4/h); h0 is the height at the wall. [landau1987, par. 61].
    """
    height = math.sqrt(2.0 * (1.0 - math.sin(contact_angle)))
    tail = 4.0 * math.exp(-float(np.arccosh(2.0 / height)) + math.sqrt(4.0 - height**2) - 2.0)
    return math.copysign(tail, math.cos(contact_angle))


SIZES = ((1.0, 1.0), (0.6, 0.6), (1.0, 0.6))
"""Radii of both floats, mm."""
DISTANCES = (4.0, 6.0, 9.0)
"""Initial distances of the centers, mm."""
MEETING_TOLERANCE = 1e-3
"""The tolerance over the expected time."""
MEETING_FRAMES = 400
"""Frames until the expected contact; a run is a tenth longer."""


def meeting_rows() -> list[Row]:
    """Compare the time of contact for each pair and distance, with and without drag."""
    return [meeting(sizes, distance, drag=drag) for drag in (False, True) for sizes in SIZES for distance in DISTANCES]


def meeting(sizes: tuple[float, float], distance: float, *, drag: bool) -> Row:
    """Compare the time of contact of one pair (s)."""
    scene = _meeting_scene(sizes, distance, drag, 1.0)
    expected = meeting_time(bodies_of(scene), 1e-3 * distance, liquid_of(scene))
    computed = _met_after(_meeting_scene(sizes, distance, drag, expected / MEETING_FRAMES))
    name = f"R = {sizes[0]:g} and {sizes[1]:g} mm, {distance:g} mm apart, {'drag' if drag else 'no drag'}: time (s)"
    return within(name, computed, expected, MEETING_TOLERANCE * expected)


def _meeting_scene(sizes: tuple[float, float], distance: float, drag: bool, frame_every: float) -> FloatingScene:
    return floating_scene(
        "meeting",
        [
            *(f"particles[{k}].radius={size} mm" for k, size in enumerate(sizes)),
            f"particles[1].positions=[[{1e-3 * distance}, 0.0]]",
            f"hydrodynamics.drag={'stokes' if drag else 'none'}",
            f"frame_every={frame_every!r}",
            f"duration={1.1 * MEETING_FRAMES * frame_every!r}",
        ],
    )


def _met_after(scene: FloatingScene) -> float:
    """The time of contact, extrapolated from the last frame with an open gap; infinite without contact."""
    reach = sum(given.radius for given in scene.particles)
    touching = math.inf
    for frame in simulate(scene):
        gap = float(np.diff(frame.arrays["position"][:, 0])[0]) - reach
        closing = -float(np.diff(frame.arrays["velocity"][:, 0])[0])
        if gap <= 0.0 or (closing <= 0.0 and frame.time > 0.0):
            return touching
        touching = frame.time + gap / closing if closing else math.inf
    return math.inf


FLOATS = {"heavy": 1300.0, "light": 200.0}
"""Densities, kg/m^3."""
GLASSES = {"wetting": 45.0, "non-wetting": 120.0}
"""Contact angles, deg."""
DISHES = (10.0, 25.0)
"""Radii, mm."""
FROM_WALL = 4.0
"""Initial distance of the center from the wall, mm."""
WAY = 2.0
"""The displacement that is timed, mm; a float that climbs has not yet touched the wall."""
WALL_TOLERANCE = 1e-3
"""The tolerance over the displacement."""


def wall_rows() -> list[Row]:
    """Compare the displacement of each float at each wall of each dish, with and without drag."""
    return [drift(*choice) for choice in product(FLOATS, GLASSES, DISHES, (False, True))]


def drift(kind: str, glass: str, dish: float, drag: bool) -> Row:
    """Compare a displacement with 2 mm, at the time at which the reference has moved by this distance (mm); positive
    towards the wall.
    """
    start = 1e-3 * (dish - FROM_WALL)
    changes = [
        f"particles[0].density={FLOATS[kind]}",
        f"particles[0].positions=[[{start!r}, 0.0]]",
        f"dish.radius={dish} mm",
        f"dish.contact_angle={GLASSES[glass]} deg",
        f"hydrodynamics.drag={'stokes' if drag else 'none'}",
    ]
    scene = floating_scene("walls", changes)
    bowl = Bowl(1e-3 * dish, math.radians(GLASSES[glass]), liquid_of(scene))
    (body,) = bodies_of(scene)
    time = time_in_bowl(body, start, 1e-3 * WAY, bowl)
    expected = 1e3 * (place_in_bowl(body, start, time, bowl) - start)
    (*_, last) = frames_of("walls", [*changes, f"duration={time!r}", f"frame_every={time!r}"])
    computed = 1e3 * (float(last.arrays["position"][0, 0]) - start)
    name = f"{kind}, {glass} wall, dish of {dish:g} mm, {'drag' if drag else 'no drag'}, {time:.3g} s: drift (mm)"
    return within(name, computed, expected, WALL_TOLERANCE * WAY)


ORDERS = {"velocity-verlet": 2, "explicit-euler": 1, "stormer-verlet": 2, "semi-implicit-euler": 1, "rk4": 4}
INTEGRATOR_STEPS = (128, 256)
"""Numbers of steps in about a third of an oscillation."""
INTEGRATOR_TOLERANCE = 0.05
LONG_STEP = 4e-3
"""A time step (s) of a fortieth of an oscillation."""
MANY, LOOK_EVERY = 1_000_000, 1000
"""Steps, and steps between two evaluations of the energy."""
MOST_CHANGE, MOST_GROWTH, EULER_CHANGE = 1e-3, 1.05, 0.5
"""Limits of the energy change of Verlet's scheme over the energy of the oscillation, of that in the second half over
the first, and the change that Euler's scheme exceeds.
"""


def integrator_rows() -> list[Row]:
    """Compare five orders of convergence, and three numbers on energies."""
    with warnings.catch_warnings():
        # the steps are long on purpose
        warnings.simplefilter("ignore", StepWarning)
        return [*(order(name) for name in ORDERS), *energies()]


def order(integrator: str) -> Row:
    """The order of convergence of an integrator, from the errors at two time steps."""
    scene = _integrator_scene(integrator, 0.32 / INTEGRATOR_STEPS[0], 0.32)
    assert scene.dish is not None  # noqa: S101  # the scene has one
    assert scene.dish.radius is not None  # noqa: S101  # and it is round
    start = scene.particles[0].positions[0][0]
    bowl = Bowl(scene.dish.radius, scene.dish.contact_angle, liquid_of(scene))
    (body,) = bodies_of(scene)
    exact = place_in_bowl(body, start, scene.duration, bowl)
    errors = [
        abs(_end(_integrator_scene(integrator, scene.duration / steps, scene.duration)) - exact)
        for steps in INTEGRATOR_STEPS
    ]
    return within(f"{integrator}: order", math.log2(errors[0] / errors[1]), ORDERS[integrator], INTEGRATOR_TOLERANCE)


def energies(steps: int = MANY) -> list[Row]:
    """Compare energies: with Verlet's scheme the energy oscillates without growth; with Euler's it grows until the
    float is ejected.
    """
    kept = energy_changes(simulate(_long_scene("velocity-verlet", steps, LOOK_EVERY)))
    lost = energy_changes(_until_thrown_out(simulate(_long_scene("explicit-euler", steps, LOOK_EVERY // 100))))
    first, second = max(kept[: len(kept) // 2]), max(kept[len(kept) // 2 :])
    name = f"velocity-verlet, {steps} steps: change of energy"
    return [
        below(f"{name}, over the swing's", max(first, second), MOST_CHANGE),
        below(f"{name}, second half over first", second / first, MOST_GROWTH),
        above("explicit-euler: change of energy before it is thrown out, over the swing's", max(lost), EULER_CHANGE),
    ]


def energy_changes(frames: Iterable[Frame]) -> list[float]:
    """The difference of the energy of each frame from the first, over the energy of the oscillation."""
    found = list(_energies(frames))
    swing = found[0] - _lowest()
    return [abs(energy - found[0]) / swing for energy in found]


def _until_thrown_out(frames: Iterable[Frame]) -> Iterator[Frame]:
    """The frames until the run fails, which is expected here."""
    try:
        yield from frames
    except Diverged:
        return


def _lowest() -> float:
    """The energy of a float at rest in the middle (J)."""
    resting = case_scene("integrators", ["particles[0].positions=[[0.0, 0.0]]"])
    return next(iter(_energies(simulate(resting))))


def _energies(frames: Iterable[Frame]) -> Iterable[float]:
    return (frame.numbers["total_energy"] for frame in frames)


def _long_scene(integrator: str, steps: int, every: int) -> FloatingScene:
    return _integrator_scene(integrator, LONG_STEP, every * LONG_STEP, steps // every)


def _end(scene: FloatingScene) -> float:
    (*_, last) = simulate(scene)
    return float(last.arrays["position"][0, 0])


def _integrator_scene(integrator: str, step: float, frame_every: float, frames: int = 1) -> FloatingScene:
    return floating_scene(
        "integrators",
        [
            f"integration.integrator={integrator}",
            f"integration.time_step={step!r}",
            f"frame_every={frame_every!r}",
            f"duration={frames * frame_every!r}",
        ],
    )


UNITS, RAFT_FRAMES = 60.0, 120
"""Duration in units of time, and the number of frames."""
PULL = 0.02
"""The force 2 pi gamma A^2/L, in units of mass, capillary length and time, which defines the unit of time."""
RAFT_STEPS = (0.01, 0.04)
"""Time steps of the trial from which the case comes, in units of time; ecume chooses 0.05."""
COARSEST = 0.2
"""Four times the step that ecume chooses."""
DEEPEST, RISES, DRIFT = 1e-3, 1e-5, 1e-12
"""Limits: of overlaps over a radius, of rises of the energy over its whole change, and of the total momentum over the
sum of magnitudes.
"""
SEEDS = range(1, 26)
"""Random starts. The folding of a raft is chaotic: the last bits of a force change rises of the energy tenfold. The
median of 25 starts drawn from 40 stayed below three quarters of its limit 400 times, that of five did not.
"""
COARSE_RISES = RISES * (COARSEST / 0.05) ** 2
"""The energy oscillates with an amplitude proportional to the square of the step."""


def unit_of_time() -> float:
    """The unit of time sqrt(0.02 m L/(2 pi gamma A^2/L)) (s)."""
    scene = case_scene("raft")
    floats, liquid = MODELS["floating"].parameters(scene).floats, liquid_of(scene)
    pull = pair_strength(liquid.surface_tension, float(floats.charge[0]), float(floats.charge[0]))
    return math.sqrt(PULL * float(floats.mass[0]) * liquid.capillary_length**2 / pull)


def raft_rows() -> list[Row]:
    """Compare rafts at the two steps of the trial and at four times the default step, without and with friction."""
    return [
        row
        for friction in (0.0, 0.3)
        for found in (*(raft(step, friction) for step in RAFT_STEPS), raft(COARSEST, friction, COARSE_RISES))
        for row in found
    ]


def gathered(step: float, friction: float, seed: int) -> list[Frame]:
    """The frames of one raft, with steps of about `step` units."""
    unit = unit_of_time()
    every = UNITS * unit / RAFT_FRAMES
    steps = math.ceil(every / (step * unit))
    changes = [f"frame_every={every!r}", f"duration={RAFT_FRAMES * every!r}", f"contacts.friction={friction}"]
    return list(frames_of("raft", [*changes, f"integration.time_step={every / steps!r}", f"seed={seed}"]))


def rises_of(frames: list[Frame]) -> float:
    """The sum of all rises of the energy from frame to frame, over its whole change."""
    energies = np.array([frame.numbers["total_energy"] for frame in frames])
    steps_up = np.diff(energies)
    return float(steps_up[steps_up > 0].sum() / np.ptp(energies))


def raft(step: float, friction: float, rises_allowed: float = RISES, seeds: Sequence[int] = SEEDS) -> list[Row]:
    """Compare rafts from these starts: the energies of all rafts, and other quantities of the first."""
    frames, *others = [gathered(step, friction, seed) for seed in seeds]
    rises = float(np.median([rises_of(each) for each in (frames, *others)]))
    arrays, last = frames[-1].arrays, frames[-1].numbers
    momentum = math.hypot(last["momentum_x"], last["momentum_y"])
    largest = max(np.sum(f.arrays["mass"] * np.hypot(*f.arrays["velocity"].T)) for f in frames)
    name = f"19 floats, {UNITS:g} units of time, step {step:g}, mu={friction:g}"
    found = [
        below(f"{name}: deepest overlap over R", last["deepest_overlap"] / float(arrays["radius"][0]), DEEPEST),
        below(f"{name}: rises of energy over its change, median of {len(seeds)} starts", rises, rises_allowed),
        below(f"{name}: momentum over that of all floats", momentum / float(largest), DRIFT),
        below(f"{name}: rafts", last["clusters"], 1.5),
    ]
    # With friction, sweeps may not converge for a braced raft: see the page.
    smooth = [below(f"{name}: steps that did not converge", last["unconverged_steps"], 0.5)]
    return found if friction else found + smooth
