"""Contacts as impulses: collisions with restitution, and the constraints that floats do not overlap.

Collisions act on the velocities before the kick, reduced by drag: the impulses that stop all approaching pairs, times
1 + e. All other solves are plastic, on velocities after the kick. In both cases the kinetic energy can only decrease,
for any number of simultaneous contacts: a plastic solve is a projection on a convex set that contains the state of
rest, and a collision returns part of what the projection removes. Restitution of single contacts next to lasting
contacts has no such bound (Kane's paradox): floats between two neighbors would rattle forever.

With Coulomb friction, which causes spins, a collision applies (1 + e) times the impulses that stop all relative motion,
including the tangential ones. These remove a part of the kinetic energy, of which the collision returns a fraction, so
that the energy can only decrease. In a single collision a sliding contact loses mu times its normal impulse; a sticking
contact rebounds tangentially with e.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from ecume._jit import compiled, compiled_inside, selected
from ecume.engine.contact import contacts as touching
from ecume.engine.contact import friction as coulomb
from ecume.engine.contact import impulse_solvers, rolling
from ecume.engine.contact.contacts import Bodies, Contacts, DiscMotion
from ecume.engine.contact.friction import FrictionalContacts, Motion
from ecume.engine.contact.impulse_solvers import Tolerance, contact_keys, normal_velocities
from ecume.engine.contact.rolling import RollingContacts
from ecume.engine.contact.torque_contacts import TorqueContacts
from ecume.engine.outlines import Outlines
from ecume.laws import drag, flotation
from ecume.models.floating.contacts.thermal_collisions import Flow, collide_on_paths, require_distances
from ecume.models.floating.options import Built
from ecume.models.floating.parameters import (
    COLLISIONS,
    DEEPEST,
    DRIVEN,
    PUSHES,
    SWEEPS,
    UNCONVERGED,
    Parameters,
    State,
    Workspace,
    add_rows,
    copy_rows,
    is_diffusing,
    memory_of,
)
from ecume.models.floating.setup.kinds import FloatKind, distinct_kinds, turning_frictions
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


class Friction(NamedTuple):
    """Constants of contacts with friction, and with rolling resistance if a coefficient of it is above zero."""

    friction: tuple[float, float]
    """coefficients of friction between two floats, and at walls"""
    rolling: tuple[float, float]
    """coefficients of rolling friction between two floats, and at walls"""
    inertia: Array
    """(N,) kg m^2"""
    decay: Array
    """(N,) the fraction of a spin that remains after the drag of one kick"""
    spin_mobility: Array
    """(N + walls,) spin per angular impulse during one kick"""
    overlapping: bool = False
    """see `Impulses`"""


class BrownianFriction(Friction):
    """Friction between Brownian floats."""


class BarrierFriction(Friction):
    """Friction between floats in a dish with a barrier."""


class FrictionScratch(NamedTuple):
    """Workspace of contacts with friction."""

    system: FrictionalContacts | RollingContacts
    """the rows of all contacts: their type says whether floats roll"""
    spin: Array
    """(N + walls,) rad/s, during this step; walls do not turn"""
    before: Array
    """(N + walls,) rad/s, before contacts"""


def make_friction_scratch(
    part: Friction, parameters: Parameters, state: State, workspace: Workspace, moving: Any
) -> FrictionScratch:
    """Return a workspace for as many contacts as the common workspace holds."""
    count, capacity = len(parameters.kick.mobility), len(workspace.contacts.gap)
    system: Any = FrictionalContacts(workspace.contacts, coulomb.make_friction_rows(capacity))
    if any(part.rolling):
        system = RollingContacts(system, rolling.make_rolling_rows(capacity))
    return FrictionScratch(system, np.zeros(count), np.zeros(count))


def with_friction_impulses(part: Friction, state: State) -> State:
    """Return the state with an array of tangential impulses, followed by as many of rolling friction."""
    return state._replace(friction_impulse=np.zeros((1 + any(part.rolling)) * len(state.contact_impulse)))


@compiled
def solve_with_friction(
    part: Friction, scratch: FrictionScratch, bodies: Bodies, contacts: Contacts, motion: Motion, goal: Tolerance
) -> int:
    """Solve contacts with friction for these velocities and spins; return the number of sweeps."""
    touching.set_effective_masses(contacts, bodies.mobility)
    impulse_solvers.prepare(scratch.system, bodies.radius, (part.friction, part.rolling), motion)
    return impulse_solvers.solve(scratch.system, motion, goal)


@compiled
def stop_with_friction(
    part: Friction, scratch: FrictionScratch, bodies: Bodies, contacts: Contacts, velocity: Array, goal: Tolerance
) -> int:
    """Stop all relative motion, starting from zero impulses; return the number of sweeps."""
    impulse_solvers.scale(scratch.system, np.zeros(contacts.total[0]))
    motion = Motion(velocity, scratch.before, bodies.mobility, part.spin_mobility)
    return solve_with_friction(part, scratch, bodies, contacts, motion, goal)


@compiled
def push_with_friction(
    part: Friction, scratch: FrictionScratch, bodies: Bodies, contacts: Contacts, midstep_velocity: Array
) -> None:
    """Apply the impulses of collisions to the midstep velocities and the spins, with friction."""
    for row in range(contacts.total[0]):
        contacts.impulse[row] *= contacts.scratch[row]
    impulse_solvers.scale(scratch.system, contacts.scratch[: contacts.total[0]])
    impulse_solvers.start(scratch.system, Motion(midstep_velocity, scratch.spin, bodies.mobility, part.spin_mobility))


@compiled
def continue_with_friction(
    part: Friction, scratch: FrictionScratch, bodies: Bodies, contacts: Contacts, velocity: Array, goal: Tolerance
) -> int:
    """Solve for velocities and spins, starting from the stored impulses; return the number of sweeps."""
    motion = Motion(velocity, scratch.spin, bodies.mobility, part.spin_mobility)
    return solve_with_friction(part, scratch, bodies, contacts, motion, goal)


@compiled
def recall_friction(part: Friction, scratch: FrictionScratch, state: State) -> None:
    """Start from the tangential impulses and rolling torques of the previous step."""
    impulse_solvers.recall(scratch.system, memory_of(state), state.friction_impulse)


@compiled
def remember_friction(part: Friction, scratch: FrictionScratch, state: State) -> None:
    """Store the tangential impulses and rolling torques for the next step."""
    impulse_solvers.remember(scratch.system, memory_of(state), state.friction_impulse)


@compiled
def load_friction_spins(
    part: Friction, scratch: FrictionScratch, parameters: Parameters, state: State, last: bool
) -> None:
    """Apply a kick to the spins; in velocity Verlet, the other half follows at the end of the step."""
    kicked = not last or parameters.scheme.half_kicks
    for i in range(len(state.turning)):
        scratch.spin[i] = state.turning[i, 1] * (part.decay[i] if kicked else 1.0)
        scratch.before[i] = scratch.spin[i]


@compiled
def store_friction_spins(
    part: Friction, scratch: FrictionScratch, parameters: Parameters, state: State, last: bool
) -> None:
    """Store the spins in the state, and advance the angles with them."""
    for i in range(len(state.turning)):
        state.turning[i, 1] = scratch.spin[i]
        if not last:
            state.turning[i, 0] += parameters.time_step * scratch.spin[i]


def friction_of(parameters: Parameters, scene: FloatingScene, interactions: tuple[Any, ...]) -> Built:
    """The part of contacts with friction; `friction_at_step` adds the terms that depend on the time step."""
    kinds, number = distinct_kinds(scene)
    inertia = np.array([float_inertia(kind) for kind in kinds])[number]
    friction = turning_frictions(scene)
    among, dish = scene.contacts, scene.dish
    sliding = among.friction, dish.friction if dish is not None else 0.0
    resisting = among.rolling_friction, dish.rolling_friction if dish is not None else 0.0
    return Built(Friction(sliding, resisting, inertia, friction, friction))


def friction_at_step(part: Friction, parameters: Parameters, turned: Array | None, pushed: bool) -> Friction:
    """Return the part with the constants of its spin kicks, which contain the drag, unless that is in the kicks of
    an interaction that turns the floats.
    """
    dragged = turned is None or not parameters.scheme.inertia
    decay, spin_mobility = spin_kick(parameters, part.inertia, part.decay if dragged else np.zeros_like(part.decay))
    if turned is not None and not parameters.scheme.inertia:
        # The spin before contacts is that by the torques of interactions at this time.
        decay = np.ones_like(decay)
    walls = np.zeros(len(parameters.kick.mobility) - len(spin_mobility))
    timed = part._replace(decay=decay, spin_mobility=np.concatenate([spin_mobility, walls]))
    found: Friction = variant_of(timed, parameters, pushed)
    return found


def float_inertia(kind: FloatKind) -> float:
    """The moment of inertia of one float about the vertical (kg m^2), without added mass."""
    if isinstance(kind.body, flotation.Disc):
        return drag.disc_inertia(kind.mass, kind.body.radius)
    return drag.sphere_inertia(kind.density * 4.0 / 3.0 * math.pi * kind.radius**3, kind.radius)


def spin_kick(parameters: Parameters, inertia: Array, friction: Array) -> tuple[Array, Array]:
    """The fraction of each spin that remains after the drag of one kick, and the spin per angular impulse."""
    time = 0.5 * parameters.time_step if parameters.scheme.half_kicks else parameters.time_step
    if not parameters.scheme.inertia:
        return np.zeros_like(inertia), 1.0 / (friction * time)
    rate = friction / inertia * time
    with np.errstate(invalid="ignore", divide="ignore"):
        held = np.where(rate > 0.0, -np.expm1(-rate) / rate, 1.0)
    return np.exp(-rate), held / inertia


STEADY = 2.0
"""At the end of a step, an approach faster than this many kicks is a collision of the next step."""

TOLERABLE = 1e-3
"""Tolerance of a contact in one step, over the tolerated overlap; a slower approach does not bounce."""


class Impulses(NamedTuple):
    """Contacts that are solved as impulses, without friction."""

    overlapping: bool
    """whether floats collide only if they already overlap, as in the original program"""


class Outlined(NamedTuple):
    """Contacts between outlines, with lever arms."""

    outlines: Outlines
    places: int
    """the largest number of contact points of two bodies"""
    overlapping: bool = False
    """see `Impulses`"""


class BarrierOutlined(Outlined):
    """Contacts between outlines in a dish with a barrier."""


class BrownianImpulses(Impulses):
    """Impulses between Brownian floats."""


class BarrierImpulses(Impulses):
    """Impulses between floats in a dish with a barrier."""


class Variants(NamedTuple):
    """The types of a part that need further compiled code."""

    brownian: type
    """floats with thermal noise, whose collisions are computed on their paths"""
    pushed: type
    """floats in a dish with a barrier, whose walls move and count impulses"""


VARIANTS = {
    Impulses: Variants(BrownianImpulses, BarrierImpulses),
    Friction: Variants(BrownianFriction, BarrierFriction),
    Outlined: Variants(Outlined, BarrierOutlined),
}


def variant_of(part: Any, parameters: Parameters, pushed: bool) -> Any:
    """The part in the type for Brownian floats, or for floats that a barrier has `pushed`; other scenes then compile no
    code for these.
    """
    variants = VARIANTS[type(part)]
    kind = variants.brownian if is_diffusing(parameters) else variants.pushed if pushed else type(part)
    return kind(*part)


Smooth = TypeVar("Smooth", Impulses, Outlined)


def impulses_at_step(part: Smooth, parameters: Parameters, turned: Array | None, pushed: bool) -> Smooth:
    """Return the part in the type that this scene requires."""
    found: Smooth = variant_of(part, parameters, pushed)
    return found


class Solver(NamedTuple):
    """The functions of the impulse solver that differ with and without friction, and with and without thermal noise."""

    stop: Callable[..., int]
    """stop(part, scratch, bodies, contacts, velocity, goal): impulses that stop all approaches; number of sweeps"""
    push: Callable[..., None]
    """push(part, scratch, bodies, contacts, velocity): apply the impulses times the factors in `contacts.scratch`"""
    solve: Callable[..., int]
    """solve(part, scratch, bodies, contacts, velocity, goal): impulses, from the stored ones; number of sweeps"""
    recall: Callable[..., None] | None = None
    """recall(part, scratch, state): tangential impulses of the previous step"""
    remember: Callable[..., None] | None = None
    """remember(part, scratch, state): store the tangential impulses for the next step"""
    load_spins: Callable[..., None] | None = None
    """load_spins(part, scratch, parameters, state, last): spins after their kick; `last` at the end of a step"""
    store_spins: Callable[..., None] | None = None
    """store_spins(part, scratch, parameters, state, last): store spins, and advance angles, in the state"""
    collide_by_noise: Callable[..., None] | None = None
    """collide_by_noise(part, parameters, state, workspace): collisions of Brownian floats, and bounds of the solve"""
    add_pushes: Callable[..., None] | None = None
    """add_pushes(part, tally, contacts, count): add the impulses of contacts on each wall"""
    still: Callable[..., float] | None = None
    """still(part, parameters, velocity): the approach below which floats rest on one another (m/s); None for zero"""


@compiled_inside
def contact_bodies(parameters: Parameters) -> Bodies:
    """Return the data of floats and walls for the contact solver."""
    return Bodies(
        parameters.floats.radius, parameters.walls, parameters.kick.mobility, parameters.periods, parameters.passing
    )


@compiled_inside
def restitutions_of(parameters: Parameters) -> tuple[int, float, float]:
    """The number of floats, the restitution between floats, and that at walls, for `restitution_of`."""
    return len(parameters.floats.radius), parameters.restitution, parameters.wall_restitution


@compiled_inside
def restitution_of(restitutions: tuple[int, float, float], partner: int) -> float:
    """The restitution of a contact with this partner: a float, or a wall if its number is beyond the last float."""
    count, among_floats, at_walls = restitutions
    return among_floats if partner < count else at_walls


@compiled
def require_stops(overlapping: bool, parameters: Parameters, contacts: Contacts | TorqueContacts) -> float:
    """Require that pairs which collide in this step stop, from the approach speeds in `contacts.scratch`; return the
    highest of these speeds.

    Without restitution a pair moves until it touches, and is stopped in the next step.
    """
    speed, bound, gap, second = contacts.scratch, contacts.bound, contacts.gap, contacts.second
    slowest, restitutions = TOLERABLE * parameters.slop / parameters.time_step, restitutions_of(parameters)
    fastest = 0.0
    for row in range(contacts.total[0]):
        comes = speed[row] < -slowest and gap[row] + parameters.time_step * speed[row] < 0.0
        among_floats = second[row] < len(parameters.floats.radius)
        if overlapping and among_floats:
            # As in the original program, where only overlapping floats collide.
            comes = speed[row] < 0.0 and gap[row] <= 0.0
        elif restitution_of(restitutions, second[row]) == 0.0:
            comes = comes and gap[row] < parameters.slop
        bound[row] = 0.0 if comes else -np.inf
        if comes:
            fastest = max(fastest, -speed[row])
    return fastest


@compiled
def share_restitution(parameters: Parameters, contacts: Contacts | TorqueContacts, of_float: Array) -> None:
    """Compute the restitution of each float: the smallest of all simultaneous collisions in its group, which cannot
    create energy.
    """
    first, second, impulse, count = contacts.first, contacts.second, contacts.impulse, len(parameters.floats.radius)
    for i in range(count):
        of_float[i] = np.inf
    restitutions, changed = restitutions_of(parameters), True
    while changed:
        changed = False
        for row in range(contacts.total[0]):
            if impulse[row] > 0.0:
                i, j = first[row], second[row]
                least = min(of_float[i], restitution_of(restitutions, j))
                if j < count:
                    least = min(least, of_float[j])
                    changed = changed or of_float[j] > least
                    of_float[j] = least
                changed = changed or of_float[i] > least
                of_float[i] = least


@compiled
def bounce(
    part: Any,
    scratch: Any,
    parameters: Parameters,
    state: State,
    contacts: Contacts | TorqueContacts,
    velocities: tuple[Array, Array],
    of_float: Array,
) -> None:
    """Apply collisions to the midstep velocities: (1 + e) times the impulses that stop all approaches. `velocities` are
    two arrays: those before the kick, which are overwritten, and those at midstep; `of_float` (N,) receives the
    restitutions.
    """
    before, midstep_velocity = velocities
    normal_velocities(contacts, before, contacts.scratch)
    fastest = require_stops(part.overlapping, parameters, contacts)
    if fastest <= 0.0:
        return
    clear_impulses(contacts)
    goal = goal_for(parameters, fastest)
    state.tally[SWEEPS] += stop(part, scratch, contact_bodies(parameters), contacts, before, goal)
    share_restitution(parameters, contacts, of_float)
    state.tally[COLLISIONS] += count_bounces(contacts, of_float)
    push(part, scratch, contact_bodies(parameters), contacts, midstep_velocity)
    add_pushes(part, state.tally, contacts, len(parameters.floats.radius))


@compiled_inside
def goal_for(parameters: Parameters, fastest: float) -> Tolerance:
    """Return the tolerance of impulses for an approach at this speed."""
    return Tolerance(impulse_solvers.CONVERGED * fastest, TOLERABLE * parameters.slop / parameters.time_step)


@compiled
def clear_impulses(contacts: Contacts | TorqueContacts) -> None:
    """Set all impulses to zero."""
    for row in range(contacts.total[0]):
        contacts.impulse[row] = 0.0


@compiled
def count_bounces(contacts: Contacts | TorqueContacts, of_float: Array) -> float:
    """Return the number of collisions; store the factor of each impulse in `scratch`."""
    count = 0.0
    for row in range(contacts.total[0]):
        bounces = contacts.impulse[row] > 0.0
        count += 1.0 if bounces else 0.0
        contacts.scratch[row] = 1.0 + of_float[contacts.first[row]] if bounces else 0.0
    return count


@compiled
def solve_smooth(part: Any, scratch: Any, bodies: Bodies, contacts: Contacts, velocity: Array, goal: Tolerance) -> int:
    """Solve contacts without friction; return the number of sweeps."""
    touching.set_effective_masses(contacts, bodies.mobility)
    return impulse_solvers.solve(contacts, DiscMotion(velocity, bodies.mobility), goal)


@compiled
def push_smooth(part: Any, scratch: Any, bodies: Bodies, contacts: Contacts, midstep_velocity: Array) -> None:
    """Apply the impulses of collisions to the midstep velocities."""
    for row in range(contacts.total[0]):
        contacts.impulse[row] *= contacts.scratch[row]
    touching.apply_impulses(contacts, contacts.impulse, midstep_velocity, bodies.mobility)


@compiled
def free_shares(parameters: Parameters, contacts: Contacts) -> Array:
    """The velocities of both floats of each contact by opposite unit forces, without hydrodynamic interaction."""
    gain, share = parameters.kick.gain, np.zeros((contacts.total[0], 2))
    for row in range(len(share)):
        i, j = contacts.first[row], contacts.second[row]
        share[row, 0] = gain[i]
        if j < len(gain):
            share[row, 1] = gain[j]
    return share


@compiled
def collide_smoothly(part: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Compute the collisions of Brownian floats on their paths; only lasting contacts remain for the contact solver."""
    contacts, velocity, gain = workspace.contacts, workspace.midstep_velocity, parameters.kick.gain
    share, driven = free_shares(parameters, contacts), workspace.stages[DRIVEN]
    found = collide_on_paths(parameters, state, contacts, (velocity, driven), share, Flow(np.zeros(0), 0.0))
    for i in range(len(found.impulse)):
        velocity[i, 0] += gain[i] * found.impulse[i, 0]
        velocity[i, 1] += gain[i] * found.impulse[i, 1]
    require_distances(parameters, state, contacts, velocity, share, found.lasting)


@compiled
def collide_together(part: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Leave all contacts of Brownian floats to the contact solver, which includes friction."""
    contacts = workspace.contacts
    lasting = np.ones(len(parameters.floats.radius), np.int64)
    share = free_shares(parameters, contacts)
    require_distances(parameters, state, contacts, workspace.midstep_velocity, share, lasting)


@compiled
def solve_outlines(
    part: Outlined, scratch: Any, bodies: Bodies, contacts: TorqueContacts, velocity: Array, goal: Tolerance
) -> int:
    """Solve contacts between outlines for velocities and spins; return the number of sweeps."""
    return impulse_solvers.solve(contacts, velocity, goal)


@compiled
def push_outlines(
    part: Outlined, scratch: Any, bodies: Bodies, contacts: TorqueContacts, midstep_velocity: Array
) -> None:
    """Apply the impulses of collisions to the midstep velocities and spins."""
    for row in range(contacts.total[0]):
        contacts.impulse[row] *= contacts.scratch[row]
    impulse_solvers.start(contacts, midstep_velocity)


@compiled
def add_pushes_on_walls(part: Any, tally: Array, contacts: Contacts, count: int) -> None:
    """Add the impulses of contacts on each wall to the wall impulses of this step."""
    for row in range(contacts.total[0]):
        if contacts.second[row] >= count:
            tally[PUSHES + contacts.second[row] - count] += contacts.impulse[row]


@compiled
def still_before_barrier(part: Any, parameters: Parameters, velocity: Array) -> float:
    """The tolerance of the contact solve while a wall moves. A barrier pushes rows of floats against drag; their speeds
    are equal to within this tolerance. The velocities of walls follow those of the floats in the array.
    """
    for row in range(len(parameters.floats.radius), len(velocity)):
        if velocity[row, 0] != 0.0 or velocity[row, 1] != 0.0:
            return TOLERABLE * parameters.slop / parameters.time_step
    return 0.0


SMOOTH = Solver(solve_smooth, push_smooth, solve_smooth)
ROUGH = Solver(
    stop_with_friction,
    push_with_friction,
    continue_with_friction,
    recall_friction,
    remember_friction,
    load_friction_spins,
    store_friction_spins,
)
OUTLINES = Solver(solve_outlines, push_outlines, solve_outlines)
SOLVERS: dict[type, Solver] = {
    Impulses: SMOOTH,
    BrownianImpulses: SMOOTH._replace(collide_by_noise=collide_smoothly),
    BarrierImpulses: SMOOTH._replace(add_pushes=add_pushes_on_walls, still=still_before_barrier),
    Friction: ROUGH,
    BrownianFriction: ROUGH._replace(collide_by_noise=collide_together),
    BarrierFriction: ROUGH._replace(add_pushes=add_pushes_on_walls, still=still_before_barrier),
    Outlined: OUTLINES,
    BarrierOutlined: OUTLINES._replace(add_pushes=add_pushes_on_walls, still=still_before_barrier),
}
"""The solvers by type of the part."""

stop = selected(SOLVERS, "stop")
push = selected(SOLVERS, "push")
solve = selected(SOLVERS, "solve")
recall = selected(SOLVERS, "recall")
remember = selected(SOLVERS, "remember")
load_spins = selected(SOLVERS, "load_spins")
store_spins = selected(SOLVERS, "store_spins")
collide_by_noise = selected(SOLVERS, "collide_by_noise")
add_pushes = selected(SOLVERS, "add_pushes")
still = selected(SOLVERS, "still", 0)


@compiled
def goal_of(parameters: Parameters, contacts: Contacts | TorqueContacts) -> Tolerance:
    """Return the tolerance of impulses for the speeds in `contacts.scratch`; zero if no pair approaches too far."""
    fastest = 0.0
    for row in range(contacts.total[0]):
        fastest = max(fastest, contacts.bound[row] - contacts.scratch[row])
    return goal_for(parameters, fastest)


@compiled
def solve_contacts(
    part: Any,
    scratch: Any,
    parameters: Parameters,
    state: State,
    contacts: Contacts | TorqueContacts,
    velocity: Array,
) -> None:
    """Solve for impulses on `velocity`, starting from those of the previous solve, and store them."""
    memory = memory_of(state)
    recall(part, scratch, state)
    touching.recall(contact_keys(contacts), contacts.impulse, memory, memory.impulse)
    normal_velocities(contacts, velocity, contacts.scratch)
    goal = goal_of(parameters, contacts)
    most = 0
    if goal.target > 0.0:
        most = solve(part, scratch, contact_bodies(parameters), contacts, velocity, goal)
    else:
        clear_impulses(contacts)
    add_pushes(part, state.tally, contacts, len(parameters.floats.radius))
    state.tally[SWEEPS] += most
    state.tally[UNCONVERGED] += 1.0 if most > impulse_solvers.MOST_SWEEPS else 0.0
    touching.remember(contact_keys(contacts), contacts.impulse, memory, memory.impulse)
    remember(part, scratch, state)


@compiled
def collide(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Solve collisions, then a plastic solve for the midstep velocities, so that no float overlaps another after the
    step.

    The velocities change with the midstep velocities. `before`, the velocities before the kick, is overwritten.
    """
    contacts, midstep_velocity = workspace.contacts, workspace.midstep_velocity
    load_spins(part, scratch, parameters, state, False)
    # Twice the travel for a head-on pair; another factor of two for floats that other floats push.
    reach = 4.0 * workspace.travel[0] + parameters.slop
    touching.gather(contacts, workspace.candidates, state.position, contact_bodies(parameters), reach)
    split_velocities(parameters, state, workspace)
    bounce(part, scratch, parameters, state, contacts, (workspace.before, midstep_velocity), workspace.restitution)
    require_gaps(part.overlapping, parameters, contacts)
    collide_by_noise(part, parameters, state, workspace)
    solve_contacts(part, scratch, parameters, state, contacts, midstep_velocity)
    add_rows(state.velocity, midstep_velocity)
    store_spins(part, scratch, parameters, state, False)


@compiled
def split_velocities(parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Separate the part of the velocities that contacts change from the remainder."""
    midstep_velocity, before, decay, velocity = (
        workspace.midstep_velocity,
        workspace.before,
        parameters.kick.decay,
        state.velocity,
    )
    for i in range(len(velocity)):
        # Only the velocity that remains after drag rebounds; in a very viscous liquid that is nearly zero.
        before[i, 0] *= decay[i]
        before[i, 1] *= decay[i]
        # The difference between the velocity and the midstep velocity is kept; changes of the latter are added to it.
        velocity[i, 0] -= midstep_velocity[i, 0]
        velocity[i, 1] -= midstep_velocity[i, 1]


@compiled
def require_gaps(overlapping: bool, parameters: Parameters, contacts: Contacts | TorqueContacts) -> None:
    """Require that no pair approaches by more than its gap in this step."""
    for row in range(contacts.total[0]):
        free = overlapping and contacts.second[row] < len(parameters.floats.radius)
        contacts.bound[row] = -np.inf if free else -max(contacts.gap[row], 0.0) / parameters.time_step


@compiled
def separate(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """List the contacts at the new positions, and remove deep overlaps without changing velocities."""
    if part.overlapping:
        return
    contacts, bodies = workspace.contacts, contact_bodies(parameters)
    reach = 2.0 * workspace.travel[0] + parameters.slop
    touching.gather(contacts, workspace.candidates, state.position, bodies, reach)
    deepest = touching.deepest_overlap(contacts.total, contacts.gap)
    state.tally[DEEPEST] = max(state.tally[DEEPEST], deepest)
    if deepest > parameters.slop:
        touching.set_effective_masses(contacts, bodies.mobility)
        touching.separate(contacts, state.position, bodies, parameters.slop)
        touching.gather(contacts, workspace.candidates, state.position, bodies, reach)


@compiled
def require_rest(parameters: Parameters, contacts: Contacts | TorqueContacts, still: float) -> None:
    """Bound the relative velocities of pairs that approach only because of the kick, or not faster than `still`, so
    that their gaps do not close; `contacts.scratch` contains the speeds with the kick, `contacts.change` those without
    it.

    A faster approach is not constrained: it is a collision of the next step.
    """
    speed, before, bound, gap = contacts.scratch, contacts.change, contacts.bound, contacts.gap
    for row in range(contacts.total[0]):
        lasting = before[row] >= -STEADY * abs(speed[row] - before[row]) - still
        bound[row] = -max(gap[row], 0.0) / parameters.time_step if lasting else -np.inf


@compiled
def constrain_velocities(part: Any, scratch: Any, parameters: Parameters, state: State, workspace: Workspace) -> None:
    """Solve contacts for the velocity at the end of the step, so that compressed floats are at rest."""
    if part.overlapping:
        return
    load_spins(part, scratch, parameters, state, True)
    contacts, midstep_velocity, before = workspace.contacts, workspace.midstep_velocity, workspace.before
    decay_velocities(before, midstep_velocity, parameters.kick.decay)
    copy_rows(midstep_velocity, state.velocity)
    touching.normal_velocities(contacts, before, contacts.change)
    touching.normal_velocities(contacts, midstep_velocity, contacts.scratch)
    require_rest(parameters, contacts, float(still(part, parameters, before)))
    solve_contacts(part, scratch, parameters, state, contacts, midstep_velocity)
    copy_rows(state.velocity, midstep_velocity)
    store_spins(part, scratch, parameters, state, True)


@compiled
def decay_velocities(to: Array, velocity: Array, decay: Array) -> None:
    """Reduce velocities by the drag of one kick."""
    for i in range(len(decay)):
        to[i, 0] = decay[i] * velocity[i, 0]
        to[i, 1] = decay[i] * velocity[i, 1]
