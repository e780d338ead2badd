"""The length of the time step: that of the scene, or the longest that the stiffness of forces and the speed of floats
permit.
"""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume.engine.walls import surfaces
from ecume.models.floating.dishes import wall_stiffness, walls_of
from ecume.models.floating.forces.barrier import fastest_barrier
from ecume.models.floating.forces.flow_and_noise import fastest_at_nodes
from ecume.models.floating.forces.pair_forces import law_of, row_of, two_floats
from ecume.models.floating.options import scene_error
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    Drift,
    Floats,
    Kick,
    Parameters,
    Scheme,
    distinct_rows,
    is_diffusing,
    is_langevin,
)
from ecume.models.floating.setup.places import given_places, outermost_places
from ecume.models.step_counts import ending_on_a_step
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

GOOD = 0.05
"""Time step over the shortest time scale, with an error per step below a thousandth."""

COARSE_OVER_GOOD = 4.0
UNSTABLE_OVER_GOOD = 20.0
"""Above this factor the scheme is unstable."""

FAST = 4.0
"""A speed that few floats exceed, over the thermal velocity along one axis."""
KEPT = 0.2
"""Time step over the relaxation time of floats with inertia and noise: diffusion is too fast by a twelfth of its
square, 0.3 %.
"""

RAFT_NEIGHBORS = 6.0
PACKED = 0.9069
"""Area fraction of touching discs on a triangular lattice."""

FINE = 1e-6
"""Step of finite differences, over the distance."""

PLACES = 400
"""Number of distances for the integral of a force over a half-plane."""

SKIN_PER_STEP = 0.1
"""The largest displacement in one step, over the skin, at persistent speeds. At speeds of short duration, in the last
approach to a wall or a raft or in a growing flow, it may be ten times as large: the lists then have a wider skin.
"""


def pair_stiffness(parameters: Parameters, radius: tuple[float, float], charge: tuple[float, float]) -> float:
    """The stiffness |dF/dl| of the pair law for two floats in contact (N/m)."""
    row, law, distance = row_of(parameters), law_of(parameters), radius[0] + radius[1]
    own = two_floats(parameters, radius, charge)
    if row.stiffness is not None:
        return parameters.stiffness_factor * float(row.stiffness(distance, own, law))
    near, far = (float(row.force((1.0 + change) * distance, own, law)) for change in (-FINE, FINE))
    return parameters.stiffness_factor * abs(far - near) / (2.0 * FINE * distance)


def stiffness_over_mass(parameters: Parameters) -> tuple[Array, Array]:
    """The largest stiffness (N/m) of the forces on each kind of float, and its mass (kg)."""
    floats = parameters.floats
    kinds = distinct_rows(floats.radius, np.abs(floats.charge), floats.mass)
    # The strongest charge with the smallest or largest radius bounds all partners: a table of a thousand floats
    # requires two thousand evaluations.
    strongest, extremes = float(np.max(kinds[:, 1])), {float(np.min(kinds[:, 0])), float(np.max(kinds[:, 0]))}
    # Pair forces relax by relative motion, which is not faster than the motion of single floats.
    wall = collective_speed(parameters) * wall_stiffness(parameters)
    stiffness = [
        2.0
        * RAFT_NEIGHBORS
        * max(pair_stiffness(parameters, (radius, other), (charge, strongest)) for other in extremes)
        + wall
        for radius, charge in kinds[:, :2].tolist()
    ]
    return np.array(stiffness), kinds[:, 2]


def collective_speed(parameters: Parameters) -> float:
    """The largest ratio of the speed of a raft to that of a single float under the same force per float: walls and
    other rafts attract all floats within a capillary length together.
    """
    floats, length = parameters.floats, float(parameters.pair[CAPILLARY_LENGTH])
    within = PACKED * (length / float(floats.radius.min())) ** 2
    return max(1.0, parameters.raft_mobility * math.sqrt(min(1.0, within / len(floats.radius))))


def longest_good_step(parameters: Parameters, speed: float) -> float:
    """The longest good step (s).

    A float on a spring k oscillates with the time scale sqrt(m/k), or relaxes with zeta/k if drag dominates. Drag is
    solved exactly, so that the longer of the two limits the step: syrup requires no shorter step than water.
    """
    stiffness, mass = stiffness_over_mass(parameters)
    friction = _least_friction(parameters.floats)
    slow, skin = not parameters.scheme.inertia, parameters.skin
    speed = max(speed, thermal_speed(parameters))
    scales = [
        max(0.0 if slow else math.sqrt(m / k), friction / k) if k > 0.0 else math.inf
        for k, m in zip(stiffness, mass, strict=True)
    ]
    step = min(GOOD * min(*scales, parameters.shortest_time), diffusion_step(parameters))
    if slow:
        speed += attraction_speed(parameters)
    else:
        speed += SKIN_PER_STEP * attraction_speed(parameters)
    return min(step, SKIN_PER_STEP * skin / speed) if speed > 0.0 else step


def attraction_speed(parameters: Parameters) -> float:
    """The highest speed (m/s) of a float by the attraction of walls and of a raft of all other floats: limited by drag,
    and with inertia by the work of the force over a capillary length.
    """
    floats, length = parameters.floats, float(parameters.pair[CAPILLARY_LENGTH])
    charge, area = np.abs(floats.charge), math.pi * float(np.sum(floats.radius**2)) / PACKED
    walls = np.abs(parameters.wall_strength).sum(axis=0) / length
    pull = parameters.stiffness_factor * raft_pull(parameters, charge, area) + walls
    with np.errstate(invalid="ignore"):
        speed = collective_speed(parameters) * pull * floats.relaxation_time / floats.mass
    if parameters.scheme.inertia:
        speed = np.fmin(speed, np.sqrt(2.0 * pull * length / floats.mass))
    return float(np.max(speed))


def raft_pull(parameters: Parameters, charge: Array, area: float) -> Array:
    """The force (N) of the pair law on each float at the edge of a raft that contains all floats and covers this
    area.
    """
    row, law, floats = row_of(parameters), law_of(parameters), parameters.floats
    if row.raft_pull is not None:
        return np.asarray(row.raft_pull(charge, area, float(parameters.pair[CAPILLARY_LENGTH]), law))
    # A half-plane of floats with the largest charge: F = 2 n int |F(l)| l dl, with n floats per m^2.
    near, strongest = 2.0 * float(floats.radius.min()), float(charge.max())
    own = two_floats(parameters, (0.5 * near, 0.5 * near), (strongest, strongest))
    distance = np.geomspace(near, max(parameters.cutoff, 2.0 * near), PLACES)
    force = np.array([abs(float(row.force(each, own, law))) for each in distance.tolist()])
    whole = 2.0 * len(charge) / area * float(np.trapezoid(force * distance, distance))
    return np.full(len(charge), whole)


def thermal_speed(parameters: Parameters) -> float:
    """The speed (m/s) that few floats with inertia and thermal noise exceed; zero for all others."""
    variance = parameters.drift.thermal / float(parameters.floats.mass.min())
    return FAST * math.sqrt(variance) if is_langevin(parameters) else 0.0


def diffusion_step(parameters: Parameters) -> float:
    """The longest time step (s) that resolves thermal noise: the r.m.s. displacement of a float along one axis is GOOD
    of its radius, and with inertia its velocity is kept for several steps.
    """
    thermal, floats = parameters.drift.thermal, parameters.floats
    if thermal == 0.0:
        return math.inf
    if parameters.scheme.inertia:
        slow = np.sqrt(floats.mass / thermal)
        return float(min(KEPT * floats.relaxation_time.min(), np.min(GOOD * floats.radius * slow)))
    friction = floats.mass / floats.relaxation_time
    return float(np.min((GOOD * floats.radius) ** 2 * friction)) / (2.0 * thermal)


def diffusion_factor(time_step: float, relaxation_time: float) -> float:
    """The diffusivity of a float with inertia and noise in steps, over the exact one: (r/2) coth(r/2), r = dt/tau.

    Its velocities, exact in each step, are correlated by e^(-k r): dt <v^2> (1/2 + sum_k e^(-k r)) is the diffusivity.

    >>> [round(diffusion_factor(ratio, 1.0), 3) for ratio in (0.2, 0.8, 4.0)]
    [1.003, 1.053, 2.075]
    """
    half = 0.5 * time_step / relaxation_time
    return half / math.tanh(half)


TOO_FAST = 0.01
"""The excess of diffusion above which messages state it."""


def diffusion_remark(parameters: Parameters, time_step: float) -> str:
    """How much too fast floats with inertia and noise diffuse in steps of this length; empty where they do not."""
    if not is_langevin(parameters):
        return ""
    factor = diffusion_factor(time_step, float(parameters.floats.relaxation_time.min()))
    return f"free floats diffuse {factor:.3g} times as fast as they should; " if factor > 1.0 + TOO_FAST else ""


def _least_friction(floats: Floats) -> float:
    """The smallest friction of any float (N s/m); zero without drag."""
    return float(np.min(floats.mass / floats.relaxation_time))


LARGEST_EXPONENT = 300.0

NOISE_DEVIATIONS = 6.5
"""Displacement by noise that neighbor lists allow for, in standard deviations."""


class StepWarning(UserWarning):
    """The time step is too long for an accurate result."""


def kick_of(scheme: Scheme, time_step: float, floats: Floats, walls: int) -> Kick:
    """Return one kick of the scheme: half a step for velocity Verlet, a whole step for the others."""
    time = 0.5 * time_step if scheme.half_kicks else time_step
    if not scheme.inertia:
        gain = floats.relaxation_time / floats.mass
        return Kick(np.zeros_like(gain), gain, np.concatenate([gain / time, np.zeros(walls)]))
    ratio = time / floats.relaxation_time
    decay = np.exp(-ratio)
    with np.errstate(invalid="ignore", divide="ignore"):
        held = np.where(ratio > 0.0, -np.expm1(-ratio) / ratio, 1.0)
    gain = time / floats.mass * held
    mobility = np.concatenate([gain / time, np.zeros(walls)])
    return Kick(decay, gain, mobility)


def good_step(parameters: Parameters, scene: FloatingScene) -> float:
    """The longest good time step of a scene (s)."""
    return longest_good_step(parameters, fastest_start(parameters, scene))


def without_drag(parameters: Parameters) -> Floats:
    """The floats as kicks see them: drag that acts together with noise is apart."""
    floats = parameters.floats
    return floats._replace(relaxation_time=np.full(len(floats.mass), np.inf)) if is_langevin(parameters) else floats


class Step(NamedTuple):
    """A time step and the constants that depend on it."""

    time_step: float
    steps_per_frame: int
    kick: Kick
    drift: Drift


def step_of(parameters: Parameters, scene: FloatingScene) -> Step:
    """The time step: that of the scene, or the longest good one that divides the time between frames."""
    good, frame = good_step(parameters, scene), scene.frame_every
    given = scene.integration.time_step
    if given is not None:
        _judge(given, good, diffusion_remark(parameters, given))
    steps = max(1, math.ceil(frame / (given if given is not None else good) * (1.0 - 1e-9)))
    if given is not None and abs(steps * given - frame) > 1e-9 * frame:
        raise scene_error(
            "integration.time_step",
            f"{given:g} s does not divide frame_every = {frame:g} s; {frame / steps:.9g} s would do",
        )
    if given is None:
        steps = ending_on_a_step(scene, steps)
    time_step = frame / steps
    walls = len(parameters.kick.mobility) - len(parameters.floats.mass)
    kick = kick_of(parameters.scheme, time_step, without_drag(parameters), walls)
    jump = NOISE_DEVIATIONS * math.sqrt(2.0 * parameters.drift.thermal * float(kick.gain.max()) * time_step)
    jump = (jump if is_diffusing(parameters) else 0.0) + time_step * _swaying(parameters, kick)
    jump += 2.0 * time_step * fastest_barrier(scene.dish)  # the speed of a float that rebounds from it
    drift = parameters.drift._replace(jump=jump)
    return Step(time_step, steps, kick, drift)


def _swaying(parameters: Parameters, kick: Kick) -> float:
    """The largest change of a velocity by a moving dish in one kick (m/s)."""
    sway, floats = parameters.drift.sway, parameters.floats
    far = float(np.hypot(*sway.amplitude))
    speed, change = float(np.hypot(*sway.velocity)) + far * sway.turning, far * sway.turning**2
    change = change if parameters.scheme.inertia else 0.0
    return sway.slip * float(np.max(kick.gain * floats.mass * (change + speed / floats.relaxation_time)))


def _judge(given: float, good: float, remark: str) -> None:
    """Raise SceneError or warn if a step is too long, with a remark and a sufficient value."""
    if given > UNSTABLE_OVER_GOOD * good:
        raise scene_error(
            "integration.time_step",
            f"{given:.3g} s is unstable here; expected at most {UNSTABLE_OVER_GOOD * good:.3g} s, "
            f"{good:.3g} s is good"
        )  # fmt: skip
    if given > COARSE_OVER_GOOD * good:
        message = f"integration.time_step: {given:.3g} s is coarse; {remark}{good:.3g} s is good"
        warnings.warn(message, StepWarning, stacklevel=2)


def fastest_start(parameters: Parameters, scene: FloatingScene) -> float:
    """The largest initial speed, or the largest speed of the flow where floats are (m/s)."""
    drift, starts = parameters.drift, given_places(scene).velocity
    carried = _flow_speed(parameters, scene) + fastest_at_nodes(drift)
    carried += drift.sway.slip * (float(np.hypot(*drift.sway.velocity + drift.sway.turning * drift.sway.amplitude)))
    return max(carried, fastest_barrier(scene.dish), float(np.hypot(starts[:, 0], starts[:, 1]).max()))


def _flow_speed(parameters: Parameters, scene: FloatingScene) -> float:
    """The largest speed of a float that the linear flow carries (m/s). On an endless surface a float's velocity is
    u(t) = exp(G t) u(0) with the gradient G, whose square is -det G: a hyperbolic flow makes it grow.
    """
    flow, places = parameters.drift.flow, outermost_places(parameters, scene)
    open_water = scene.dish is None
    reach = float(np.hypot(*places.T).max()) if open_water else surfaces.farthest(walls_of(scene.dish))
    now = math.hypot(flow[0], flow[1]) + reach * float(np.abs(flow[2:]).sum())
    gradient = flow[2:].reshape(2, 2)
    square = -float(np.linalg.det(gradient))
    if not open_water or square <= 0.0:
        return now
    rate = math.sqrt(square)
    turned = float(np.linalg.norm(gradient, 2)) * now / rate
    return max(now, SKIN_PER_STEP * math.exp(min(rate * scene.duration, LARGEST_EXPONENT)) * (now + turned))
