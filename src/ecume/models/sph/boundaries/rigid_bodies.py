"""Motion of solids: rigid bodies in the liquid, and sides, bodies and tanks with prescribed motion.

Rigid bodies: the equations of motion, their dummy particles, and collisions. Quaternions are (w, x, y, z). Bodies
collide with sides, obstacles and each other: impulses act at the deepest point of each contact, in sweeps over all
contacts until none approaches, and bodies that overlap are moved apart. The normal of a contact points towards the
body. Impulses obey Newton's law of restitution and Coulomb's law of friction (Mirtich and Canny 1995, who resolve all
contacts by impulses). [mirtich1995]
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ecume._portable import cos, dot, length, product, sinc, solve
from ecume.engine.formulas import Jet, formula_at
from ecume.engine.shapes import Shape
from ecume.engine.walls import Sheet
from ecume.engine.walls.sheets import SIZE, SPEED
from ecume.engine.walls.surfaces import PLANE
from ecume.errors import Diverged
from ecume.models.sph.parameters import Bodies, Boundary, Drive, Dummies, Parameters, Roll
from ecume.models.sph.state import State
from ecume.units import Array

LEAST_DELAY = 4.0
"""The smallest delay, in evaluations; with less, sound waves make a body oscillate."""
ANSWERED = 0.2
"""The added mass that the pressure of dummies represents, over the displaced mass, for a body with a radius of two
spacings.
"""


def rotations(pose: Array) -> Array:
    """(B, 3, 3) the rotation matrices of the bodies."""
    w, x, y, z = pose[3:]
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def placed(bodies: Bodies, dummies: Dummies, pose: Array, motion: Array) -> Dummies:
    """The dummies, with the dummies of bodies at their present positions and velocities."""
    if not bodies.shapes:
        return dummies
    d, first = len(dummies.position), bodies.first
    position, velocity = dummies.position.copy(), dummies.velocity.copy()
    body = dummies.owner[first:] - dummies.owner[first]
    own = np.pad(dummies.position[:, first:], ((0, 3 - d), (0, 0)))
    arm = np.einsum("nab,bn->an", rotations(pose)[body], own)
    position[:, first:] = (pose[:3, body] + arm)[:d]
    velocity[:, first:] = (motion[:3, body] + np.cross(motion[3:, body].T, arm.T).T)[:d]
    return dummies._replace(position=position, velocity=velocity)


def apparent_gravity(bodies: Bodies, dummies: Dummies, state: tuple[Array, Array, Array], gravity: Array) -> Array:
    """Gravity less the acceleration of each dummy, (d, D), from poses, motions and accelerations of the bodies. Walls
    and obstacles are at rest.
    """
    pulls = np.repeat(gravity[:, None], dummies.position.shape[1], axis=1)
    if bodies.shapes:
        pose, motion, acceleration = state
        d, first = pulls.shape[0], bodies.first
        body = dummies.owner[first:] - (dummies.owner[first] if len(dummies.owner) > first else 0)
        arm = (np.pad(dummies.position[:, first:], ((0, 3 - d), (0, 0))) - pose[:3, body]).T
        spin = motion[3:, body].T
        own = acceleration[:3, body].T + np.cross(acceleration[3:, body].T, arm) + np.cross(spin, np.cross(spin, arm))
        pulls[:, first:] -= own.T[:d]
    return pulls


def delay(bodies: Bodies, density: float) -> Array:
    """(B,) the number of evaluations over which the acceleration that dummies use relaxes to that of their body.

    Without relaxation, a body is unstable if it is lighter than the liquid that its dummies accelerate: each change of
    its acceleration causes a larger one. A body with a twentieth of the density of the liquid diverged. The ratio of
    displaced mass to body mass is an upper bound of the gain.
    """
    volume = np.array([shape.volume() for shape in bodies.shapes])
    late: Array = LEAST_DELAY + ANSWERED * density * volume / bodies.mass
    return late


def inverse_inertia(bodies: Bodies, turn: Array) -> Array:
    """The inverse inertia tensors in the fixed frame, (B, 3, 3); zero about axes without rotation in 2D."""
    inverse = np.divide(1.0, bodies.inertia, out=np.zeros_like(bodies.inertia), where=bodies.inertia > 0.0)
    found: Array = np.einsum("nab,bn,ncb->nac", turn, inverse, turn)
    return found


def accelerations_of(bodies: Bodies, pose: Array, motion: Array, load: tuple[Array, Array], gravity: Array) -> Array:
    """(6, B) linear and angular acceleration from forces and torques (B, 3): Newton's and Euler's equations."""
    force, torque = load
    turn, spin = rotations(pose), motion[3:].T
    along = np.einsum("nba,nb->na", turn, spin) * bodies.inertia.T
    angular = torque - np.cross(spin, np.einsum("nab,nb->na", turn, along))
    acceleration = np.empty_like(motion)
    acceleration[:3] = (force / bodies.mass[:, None]).T
    acceleration[: len(gravity)] += gravity[:, None]
    acceleration[3:] = np.einsum("nab,nb->na", inverse_inertia(bodies, turn), angular).T
    return acceleration


def energy_of_bodies(parameters: Parameters, pose: Array, motion: Array) -> float:
    """Kinetic energy of translation and rotation, and potential energy in gravity and in the central pull (J), without
    bodies with a prescribed motion.
    """
    bodies, place = parameters.bodies, pose[: parameters.dimension]
    if not bodies.shapes:
        return 0.0
    spin = np.einsum("nba,bn->an", rotations(pose), motion[3:])
    mass = np.where(np.isfinite(bodies.mass), bodies.mass, 0.0)
    energy = 0.5 * float(np.sum(mass * (motion[:3] ** 2).sum(axis=0)) + np.sum(bodies.inertia * spin**2))
    away = ((place - parameters.pull_center[:, None]) ** 2).sum(axis=0)
    return energy + dot(mass, 0.5 * parameters.pull_rate**2 * away - product(parameters.gravity, place))


def move_bodies(pose: Array, motion: Array, time: float) -> None:
    """Move and rotate each body with its velocity and spin."""
    pose[:3] += time * motion[:3]
    for body in range(pose.shape[1]):
        pose[3:, body] = turned(pose[3:, body], time * motion[3:, body])


def turned(quaternion: Array, angle: Array) -> Array:
    """A quaternion after rotation by a rotation vector (rad) in the fixed frame."""
    size = length(angle)
    share = sinc(0.5 * size / np.pi) * 0.5
    a, (b, c, d) = cos(0.5 * size), share * angle
    w, x, y, z = quaternion
    turn = np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )
    result: Array = turn / length(turn)
    return result


def largest_displacement(bodies: Bodies, pose: Array, reference: Array) -> float:
    """An upper bound of the displacement of any point of a body since the reference."""
    most = 0.0
    for body, rim in enumerate(bodies.rims):
        way = length(pose[:3, body] - reference[:3, body])
        turn = 2.0 * min(1.0, length(pose[3:, body] - reference[3:, body]))
        most = max(most, way + turn * float(np.sqrt((rim**2).sum(axis=1).max())))
    return most


class Expelled(NamedTuple):
    """The result of moving liquid out of bodies."""

    hits: int
    """the number of particles"""
    work: float
    """J, of bodies with a prescribed motion"""
    impulse: Array
    """(B, 6) N s and N m s: the impulse and the angular impulse, about its center, on each body"""


def expel_liquid(bodies: Bodies, pose: Array, motion: Array, liquid: tuple[Array, Array, Array]) -> Expelled:
    """Move the liquid particles inside a body (position, velocity, mass) to its surface. The momentum of liquid and
    other bodies is conserved.
    """
    position, velocity, mass = liquid
    d, hits, work, impulses = len(position), 0, 0.0, np.zeros((len(bodies.shapes), 6))
    for body, shape in enumerate(bodies.shapes):
        reach = np.sqrt((bodies.rims[body] ** 2).sum(axis=1).max())
        away = position - pose[:d, body : body + 1]
        close = np.flatnonzero((away**2).sum(axis=0) < reach**2)
        turn = rotations(pose[:, body : body + 1])[0][:d, :d]
        gap, normal = shape.nearest(product(away[:, close].T, turn))
        inside = np.flatnonzero(gap < 0.0)
        for i, depth, own in zip(close[inside], -gap[inside], normal[inside], strict=True):
            out = product(turn, own)
            position[:, i] += depth * out
            impulse, arm, done = _bounce(
                bodies, body, (pose, motion), (position[:, i], velocity[:, i], float(mass[i]), out)
            )
            work += done
            impulses[body] -= np.concatenate([impulse, np.cross(arm, impulse)])
        hits += len(inside)
    return Expelled(hits, work, impulses)


def _bounce(
    bodies: Bodies, body: int, state: tuple[Array, Array], particle: tuple[Array, Array, float, Array]
) -> tuple[Array, Array, float]:
    """Stop the approach of a particle and a body by a perfectly inelastic impulse; return the impulse on the particle,
    its lever arm, and the work (J) of a body with a prescribed motion.
    """
    pose, motion = state
    x, v, mass, out = particle
    arm, normal = np.pad(x, (0, 3 - len(x))) - pose[:3, body], np.pad(out, (0, 3 - len(out)))
    surface = motion[:3, body] + np.cross(motion[3:, body], arm)
    approach = dot(v - surface[: len(v)], out)
    if approach >= 0.0:
        return np.zeros(3), arm, 0.0
    turning = np.cross(product(inverse_inertia_of(bodies, body, pose), np.cross(arm, normal)), arm)
    impulse = -approach / (1.0 / mass + 1.0 / bodies.mass[body] + dot(normal, turning)) * normal
    v += impulse[: len(v)] / mass
    if math.isinf(bodies.mass[body]):
        return impulse, arm, dot(impulse, surface)
    apply_impulse(bodies, body, state, (-impulse, arm))
    return impulse, arm, 0.0


def apply_impulse(bodies: Bodies, body: int, state: tuple[Array, Array], impulse: tuple[Array, Any]) -> None:
    """Apply an impulse to a body at a lever arm from its center."""
    pose, motion = state
    inverse = inverse_inertia_of(bodies, body, pose)
    motion[:3, body] += impulse[0] / bodies.mass[body]
    motion[3:, body] += product(inverse, np.cross(impulse[1], impulse[0]))


def inverse_inertia_of(bodies: Bodies, body: int, pose: Array) -> Array:
    """The inverse inertia tensor of one body, (3, 3)."""
    turn = rotations(pose[:, body : body + 1])[0]
    own = bodies.inertia[:, body]
    inverse = np.divide(1.0, own, out=np.zeros(3), where=own > 0.0)
    found: Array = product(turn * inverse, turn.T)
    return found


SWEEPS = 12
NOTHING = -1


class Contact(NamedTuple):
    """The contact of a body with another body, a side or an obstacle."""

    body: int
    other: int
    """or NOTHING"""
    point: Array
    """(3,)"""
    normal: Array
    """(3,)"""
    depth: float
    velocity: Array
    """(3,) of a wall"""


def collide(bodies: Bodies, sheet: Sheet, state: tuple[Array, Array], calm: float) -> tuple[int, float]:
    """Resolve all contacts of bodies and change their poses and motions; return the number of contacts before that, and
    the work of moving walls (J). Approaches slower than `calm` have no restitution.
    """
    first, work = 0, 0.0
    for sweep in range(SWEEPS):
        found = list(contacts(bodies, sheet, state[0]))
        first = first if sweep else len(found)
        if not found:
            break
        for contact in found:
            _separate(bodies, state[0], contact)
            impulse = _strike(bodies, state, contact, calm)
            work += dot(impulse, contact.velocity) + _work_of_driven(bodies, state, contact, impulse)
    return first, work


def _work_of_driven(bodies: Bodies, state: tuple[Array, Array], contact: Contact, impulse: Array) -> float:
    """The work (J) of a body with a prescribed motion on the other body of a contact."""
    work = 0.0
    for body, sign in ((contact.body, -1.0), (contact.other, 1.0)):
        if body != NOTHING and math.isinf(bodies.mass[body]):
            arm = contact.point - state[0][:3, body]
            work += sign * dot(impulse, state[1][:3, body] + np.cross(state[1][3:, body], arm))
    return work


def contacts(bodies: Bodies, sheet: Sheet, pose: Array) -> Iterator[Contact]:
    """The deepest point of each overlapping pair."""
    rims = [pose[:3, b] + product(rim, rotations(pose[:, b : b + 1])[0].T) for b, rim in enumerate(bodies.rims)]
    none, driven = np.zeros(3), {body for body, _ in bodies.paths}
    for body, rim in enumerate(rims):
        if body not in driven:
            yield from _with_walls(bodies, sheet, pose, body, rim)
        for other in range(body):
            if not {body, other} <= driven and _close(bodies, pose, body, other):
                yield from _between(body, other, rim, (bodies.shapes[other], pose[:, other : other + 1]), none)
                yield from _between(other, body, rims[other], (bodies.shapes[body], pose[:, body : body + 1]), none)


def _with_walls(bodies: Bodies, sheet: Sheet, pose: Array, body: int, rim: Array) -> Iterator[Contact]:
    """The contacts of a body with sides and obstacles."""
    for k in np.flatnonzero((sheet.kind[:, 0] == PLANE) & (sheet.kind[:, 2] == 0)):
        gap = product(rim, sheet.number[k, :3]) - sheet.number[k, SIZE]
        deep = int(np.argmin(gap))
        if gap[deep] < 0.0:
            velocity = sheet.number[k, SPEED : SPEED + 3]
            yield Contact(body, NOTHING, rim[deep], sheet.number[k, :3], -float(gap[deep]), velocity)
    for shape, its in zip(bodies.obstacles, bodies.obstacle_rims, strict=True):
        yield from _between(body, NOTHING, rim, (shape, None), np.zeros(3))
        yield from _flipped(_inside(bodies, body, pose, its), body)


def _between(
    body: int, other: int, rim: Array, solid: tuple[Shape, Array | None], velocity: Array
) -> Iterator[Contact]:
    """The deepest point of a body inside a solid, if there is one."""
    shape, pose = solid
    d = len(shape.middle())
    turn = np.eye(3) if pose is None else rotations(pose)[0]
    own = rim if pose is None else product(rim - pose[:3, 0], turn)
    gap, normal = shape.nearest(own[:, :d])
    deep = int(np.argmin(gap))
    if gap[deep] < 0.0:
        out = product(turn[:, :d], normal[deep])
        yield Contact(body, other, rim[deep], out, -float(gap[deep]), velocity)


def _inside(bodies: Bodies, body: int, pose: Array, rim: Array) -> Iterator[Contact]:
    yield from _between(NOTHING, body, rim, (bodies.shapes[body], pose[:, body : body + 1]), np.zeros(3))


def _flipped(found: Iterator[Contact], body: int) -> Iterator[Contact]:
    for contact in found:
        yield contact._replace(body=body, other=NOTHING, normal=-contact.normal)


def _close(bodies: Bodies, pose: Array, one: int, other: int) -> bool:
    reach = sum(np.sqrt((bodies.rims[body] ** 2).sum(axis=1).max()) for body in (one, other))
    return bool(length(pose[:3, one] - pose[:3, other]) < reach)


def _separate(bodies: Bodies, pose: Array, contact: Contact) -> None:
    if contact.other == NOTHING:
        pose[:3, contact.body] += contact.depth * contact.normal
        return
    mine, theirs = bodies.mass[contact.body], bodies.mass[contact.other]
    if math.isinf(mine) or math.isinf(theirs):
        yields = contact.body if math.isinf(theirs) else contact.other
        pose[:3, yields] += contact.depth * contact.normal * (1.0 if yields == contact.body else -1.0)
        return
    pose[:3, contact.body] += contact.depth * theirs / (mine + theirs) * contact.normal
    pose[:3, contact.other] -= contact.depth * mine / (mine + theirs) * contact.normal


def _strike(bodies: Bodies, state: tuple[Array, Array], contact: Contact, calm: float) -> Array:
    """Apply the impulse of a contact to its body, and return it."""
    pose, motion = state
    pair = [contact.body] if contact.other == NOTHING else [contact.body, contact.other]
    arms = [contact.point - pose[:3, body] for body in pair]
    speeds = [motion[:3, body] + np.cross(motion[3:, body], arm) for body, arm in zip(pair, arms, strict=True)]
    approach = speeds[0] - (contact.velocity if contact.other == NOTHING else speeds[1])
    normal_speed = dot(approach, contact.normal)
    if normal_speed >= 0.0:
        return np.zeros(3)
    give_way = sum(_compliance(bodies, body, pose, arm) for body, arm in zip(pair, arms, strict=True))
    bounce = min(bodies.restitution[body] for body in pair) if normal_speed < -calm else 0.0
    # The impulse of a sticking contact; outside of the friction cone, the tangential part is reduced to the cone.
    needed_impulse = solve(give_way, -approach - bounce * normal_speed * contact.normal)
    along = dot(needed_impulse, contact.normal)
    across = needed_impulse - along * contact.normal
    limit = min(bodies.friction[body] for body in pair) * along
    size = length(across)
    if size > limit or along <= 0.0:
        slip = across / size if size > 0.0 else across
        way = contact.normal + min(bodies.friction[body] for body in pair) * slip
        along = -(1.0 + bounce) * normal_speed / dot(contact.normal, product(give_way, way))
        needed_impulse = along * way
    apply_impulse(bodies, pair[0], state, (needed_impulse, arms[0]))
    if len(pair) == 2:
        apply_impulse(bodies, pair[1], state, (-needed_impulse, arms[1]))
    return needed_impulse


def _compliance(bodies: Bodies, body: int, pose: Array, arm: Array) -> Array:
    """The velocity at the end of the lever arm per unit impulse there, (3, 3)."""
    cross = np.cross(np.eye(3), arm)
    inverse = inverse_inertia_of(bodies, body, pose)
    found: Array = np.eye(3) / bodies.mass[body] + product(product(cross, inverse), cross.T)
    return found


def rotated(turn: Array, arm: Array) -> Array:
    """A vector after rotation by a rotation vector: Rodrigues's formula."""
    angle = math.sqrt(dot(turn, turn))
    if angle == 0.0:
        return arm
    axis = turn / angle
    along = dot(axis, arm) * axis
    across: Array = math.cos(angle) * (arm - along) + math.sin(angle) * np.cross(axis, arm)
    return along + across


def drive_at(drive: Drive, time: float) -> tuple[Array, Array, Array]:
    """The value of a drive, and its first and second derivatives with respect to time; the drive is a sine, a piecewise
    linear table, or formulas.
    """
    angle = drive.turning * time + drive.phase
    value = drive.amplitude * (math.sin(angle) + drive.start)
    rate = drive.amplitude * drive.turning * math.cos(angle)
    second = -drive.amplitude * drive.turning**2 * math.sin(angle)
    times, rows = drive.times, drive.values
    value = value + np.array([np.interp(time, times, row) for row in rows])
    piece = int(np.searchsorted(times, time, side="right"))
    if 0 < piece < len(times):
        rate = rate + (rows[:, piece] - rows[:, piece - 1]) / (times[piece] - times[piece - 1])
    if drive.formulas:
        jets = np.array([_jet_at(text, time) for text in drive.formulas])
        value, rate, second = value + jets[:, 0], rate + jets[:, 1], second + jets[:, 2]
    return value, rate, second


def _jet_at(text: str, time: float) -> Jet:
    """The value of a formula and its derivatives. Raises Diverged where it has none, between the times at which the
    scene tried it.
    """
    try:
        return formula_at(text, time)
    except (ArithmeticError, ValueError):
        message = f"the formula {text} or a derivative has no finite value at t = {time:.6g} s"
        raise Diverged(f"{message}; expected one that has, throughout the run") from None


def with_moved_solids(parameters: Parameters, state: State) -> Parameters:
    """The parameters with all solids and sides at their present positions."""
    return at(parameters, float(state.clock[0]), state.pose, state.motion)


def at_reference(parameters: Parameters, state: State) -> Parameters:
    """The parameters with all solids and sides at the positions that they had when the lists were made."""
    return at(parameters, float(state.clock[1]), state.pose_reference, state.motion)


def at(parameters: Parameters, time: float, pose: Array, motion: Array) -> Parameters:
    """The parameters with all solids and sides at their positions at one time."""
    if not parameters.moves:
        return parameters
    boundary = parameters.boundary
    dummies = placed(parameters.bodies, boundary.dummies, pose, motion)
    centers = boundary.centers.copy()
    centers[len(centers) - pose.shape[1] :] = pose[:3].T
    boundary = boundary._replace(dummies=dummies, centers=centers)
    for number, drive in parameters.drives:
        boundary = _driven(boundary, number, drive_at(drive, time))
    parameters = parameters._replace(boundary=boundary)
    more = added_gravity(parameters, time)
    return parameters if more is None else _accelerated(parameters, more)


def turned_gravity(roll: Roll, gravity: Array, time: float) -> Array:
    """What the roll adds to gravity (d,) in the frame of the tank."""
    angle = float(drive_at(roll.drive, time)[0][0])
    upright = np.pad(gravity, (0, 3 - len(gravity)))
    turned = rotated(-angle * roll.axis, upright)
    return (turned - upright)[: len(gravity)]


def added_gravity(parameters: Parameters, time: float) -> Array | None:
    """What base excitation and roll add to gravity in the frame of the tank (m/s^2); None without them."""
    more = None
    if parameters.base_excitation is not None:
        more = drive_at(parameters.base_excitation, time)[0]
    if parameters.roll is not None:
        turned = turned_gravity(parameters.roll, parameters.gravity, time)
        more = turned if more is None else more + turned
    return more


def _driven(boundary: Boundary, number: int, drive: tuple[Array, Array, Array]) -> Boundary:
    """The boundary with one driven mirror, and the reflecting surface behind it, at the position given by its drive."""
    value, rate, second = (float(part[0]) for part in drive)
    axis, d = number // 2, boundary.sides.normal.shape[1]
    row = boundary.image_owner == number
    point, table = boundary.sides.point.copy(), boundary.table.copy()
    point[row, axis] += value
    table[row, axis] += value
    table[row, 2 * d + axis] += rate
    table[row, 3 * d + 2 + axis] += second
    surface, packed = boundary.guard.owner == number, boundary.guard.sheet
    numbers = packed.number.copy()
    numbers[surface, SIZE] += numbers[surface, axis] * value
    numbers[surface, SPEED + axis] = rate
    guard = boundary.guard._replace(sheet=packed._replace(number=numbers))
    return boundary._replace(sides=boundary.sides._replace(point=point), table=table, guard=guard)


def _accelerated(parameters: Parameters, more: Array) -> Parameters:
    """The parameters with the present apparent gravity and its hydrostatic gradient, which is zero along periodic
    sides.
    """
    sides, constants = parameters.boundary.sides, parameters.constants.copy()
    held = more * (np.abs(sides.normal[sides.mirrors == 0]).sum(axis=0) == 0.0)
    material = parameters.material
    rise = parameters.density_diffusion.rise(material.density, material.sound_speed) * held
    for name, own in zip(("rise_x", "rise_y", "rise_z"), rise, strict=False):
        setattr(constants[0], name, getattr(constants[0], name) + own)
    return parameters._replace(gravity=parameters.gravity + more, constants=constants)


def displacement_of_sides(parameters: Parameters, state: State) -> float:
    """The displacement of sides since the lists were made, doubled since their images move twice as far."""
    now, then = (float(time) for time in state.clock)
    ways = (drive_at(drive, now)[0] - drive_at(drive, then)[0] for _, drive in parameters.drives)
    return float(sum(abs(way[0]) for way in ways))
