"""Rigid bodies: where their particles are, what moves them. Quaternions stand as (w, x, y, z)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ecume._portable import cos, dot, length, product, sinc
from ecume.engine.shapes import Shape
from ecume.errors import Fault, SceneError
from ecume.models.sph.parameters import Bodies, Boundary, Dummies, Parameters
from ecume.models.sph.solids import shape_of
from ecume.scenes.sph import BodySpec, SphScene
from ecume.units import Array

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
TOUCHING = 1e-3
"""Of a spacing."""
LEAST_DELAY = 4.0
"""In evaluations: sound must not make a body tremble."""
ANSWERED = 0.2
"""Of the displaced liquid, what moves with a body of two spacings' radius because its dummies know how it moves."""


def bodies_of(scene: SphScene, boundary: Boundary) -> Bodies:
    """The bodies of a scene, as they start."""
    _require_possible(scene)
    shapes = [shape_of(spec) for spec in scene.bodies]
    centered = tuple(shape.carried(-shape.middle()) for shape in shapes)
    mass = np.array([mass_of(spec, shape) for spec, shape in zip(scene.bodies, shapes, strict=True)])
    inertia = np.array([shape.inertia() for shape in shapes]).reshape(-1, 3).T
    if len(scene.tank.low) == 2:
        inertia = inertia * np.array([[0.0], [0.0], [1.0]])
    first = len(boundary.names) - len(shapes)
    return Bodies(
        shapes=centered,
        rims=tuple(_wide(shape.rim(0.5 * scene.spacing)) for shape in centered),
        pose=np.array([[*_wide(shape.middle()[None])[0], *UPRIGHT] for shape in shapes]).reshape(-1, 7).T.copy(),
        motion=np.array([_motion(spec) for spec in scene.bodies]).reshape(-1, 6).T.copy(),
        mass=mass,
        inertia=np.ascontiguousarray(mass * inertia),
        restitution=np.array([spec.restitution for spec in scene.bodies]),
        friction=np.array([spec.friction for spec in scene.bodies]),
        first=int(np.count_nonzero(boundary.dummies.owner < first)),
        obstacles=tuple(shape_of(spec) for spec in scene.obstacles),
        obstacle_rims=tuple(_wide(shape_of(spec).rim(0.5 * scene.spacing)) for spec in scene.obstacles),
    )


def _require_possible(scene: SphScene) -> None:
    low, high = np.array(scene.tank.low), np.array(scene.tank.high)
    sides = [scene.tank.left, scene.tank.right, scene.tank.bottom, scene.tank.top, scene.tank.front, scene.tank.back]
    faults = []
    for index, spec in enumerate(scene.bodies):
        ends = np.stack(shape_of(spec).bounds())
        if any(side.kind == "periodic" for side in sides):
            faults.append(Fault(f"bodies[{index}]", "a tank with bodies cannot have periodic sides; use walls"))
        if (ends[0] < low - 1e-9).any() or (ends[1] > high + 1e-9).any():
            faults.append(Fault(f"bodies[{index}]", "reaches out of the tank; wanted a body inside it"))
    faults += _overlaps(scene)
    if scene.bodies and scene.method.pressure_split == "modified":
        faults.append(Fault("method.pressure_split", "came 'modified'; bodies need the whole pressure: use 'none'"))
    if faults:
        raise SceneError(faults)


def _overlaps(scene: SphScene) -> list[Fault]:
    """Bodies that start inside an obstacle or an earlier body, by more than what touching may round to."""
    faults, slack = [], TOUCHING * scene.spacing
    solids = [(f"obstacles[{n}]", shape_of(spec)) for n, spec in enumerate(scene.obstacles)]
    for index, spec in enumerate(scene.bodies):
        mine = shape_of(spec)
        for name, other in solids:
            deep = _overlap(mine, other, 0.5 * scene.spacing)
            if deep > slack:
                faults.append(Fault(f"bodies[{index}]", f"starts {deep:.3g} m inside {name}; leave room between them"))
        solids.append((f"bodies[{index}]", mine))
    return faults


def _overlap(one: Shape, other: Shape, fine: float) -> float:
    """How deep a point of either's rim is inside the other (m); negative where none is."""
    pairs = (one, other), (other, one)
    return max(-float(inside.nearest(outer.rim(fine))[0].min()) for outer, inside in pairs)


def mass_of(spec: BodySpec, shape: Shape) -> float:
    """kg; in the plane of one meter's depth."""
    return spec.mass if spec.mass is not None else float(spec.density or 0.0) * shape.volume()


def _motion(spec: BodySpec) -> list[float]:
    velocity = [*(spec.velocity or ()), 0.0, 0.0, 0.0][:3]
    return [*velocity, *(spec.spin if isinstance(spec.spin, tuple) else (0.0, 0.0, spec.spin))]


def _wide(points: Array) -> Array:
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def rotations(pose: Array) -> Array:
    """(B, 3, 3) what turns a body's own axes to where they are."""
    w, x, y, z = pose[3:]
    rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def placed(bodies: Bodies, dummies: Dummies, pose: Array, motion: Array) -> Dummies:
    """The dummies with those of bodies where the bodies are, and as fast."""
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


def pulls_of(bodies: Bodies, dummies: Dummies, state: tuple[Array, Array, Array], gravity: Array) -> Array:
    """(d, D) what pulls at the liquid as each dummy sees it: gravity less its own acceleration, from pose, motion and
    acceleration of the bodies. Walls and obstacles stand still.
    """
    pulls = np.repeat(gravity[:, None], dummies.position.shape[1], axis=1)
    if bodies.shapes:
        pose, motion, push = state
        d, first = pulls.shape[0], bodies.first
        body = dummies.owner[first:] - (dummies.owner[first] if len(dummies.owner) > first else 0)
        arm = (np.pad(dummies.position[:, first:], ((0, 3 - d), (0, 0))) - pose[:3, body]).T
        spin = motion[3:, body].T
        own = push[:3, body].T + np.cross(push[3:, body].T, arm) + np.cross(spin, np.cross(spin, arm))
        pulls[:, first:] -= own.T[:d]
    return pulls


def delay(bodies: Bodies, density: float) -> Array:
    """(B,) in how many evaluations dummies learn of their body's acceleration.

    At once, a body lighter than the liquid which its dummies move would answer its own push with a larger one, and that
    again: a twentieth of its density diverged. The displaced liquid over the body's mass bounds that from above.
    """
    volume = np.array([shape.volume() for shape in bodies.shapes])
    late: Array = LEAST_DELAY + ANSWERED * density * volume / bodies.mass
    return late


def inverse_inertia(bodies: Bodies, turn: Array) -> Array:
    """(B, 3, 3) along the axes of space; zero about an axis that a body in the plane cannot turn about."""
    inverse = np.divide(1.0, bodies.inertia, out=np.zeros_like(bodies.inertia), where=bodies.inertia > 0.0)
    found: Array = np.einsum("nab,bn,ncb->nac", turn, inverse, turn)
    return found


def pushed(bodies: Bodies, pose: Array, motion: Array, load: tuple[Array, Array], gravity: Array) -> Array:
    """(6, B) the acceleration and the change of spin, of forces and torques (B, 3): Newton's and Euler's laws."""
    force, torque = load
    turn, spin = rotations(pose), motion[3:].T
    along = np.einsum("nba,nb->na", turn, spin) * bodies.inertia.T
    angular = torque - np.cross(spin, np.einsum("nab,nb->na", turn, along))
    push = np.empty_like(motion)
    push[:3] = (force / bodies.mass[:, None]).T
    push[: len(gravity)] += gravity[:, None]
    push[3:] = np.einsum("nab,nb->na", inverse_inertia(bodies, turn), angular).T
    return push


def energy_of_bodies(parameters: Parameters, pose: Array, motion: Array) -> float:
    """Of their motion and spin, and in gravity and in the pull to a point (J)."""
    bodies, place = parameters.bodies, pose[: parameters.dimension]
    if not bodies.shapes:
        return 0.0
    spin = np.einsum("nba,bn->an", rotations(pose), motion[3:])
    energy = 0.5 * float(np.sum(bodies.mass * (motion[:3] ** 2).sum(axis=0)) + np.sum(bodies.inertia * spin**2))
    away = ((place - parameters.pull_center[:, None]) ** 2).sum(axis=0)
    return energy + dot(bodies.mass, 0.5 * parameters.pull_rate**2 * away - product(parameters.gravity, place))


def carry(pose: Array, motion: Array, time: float) -> None:
    """Move and turn every body with its velocity and spin."""
    pose[:3] += time * motion[:3]
    for body in range(pose.shape[1]):
        pose[3:, body] = turned(pose[3:, body], time * motion[3:, body])


def turned(quaternion: Array, angle: Array) -> Array:
    """A quaternion after a turn by a vector of angle (rad) about the axes of space."""
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


def farthest_way(bodies: Bodies, pose: Array, reference: Array) -> float:
    """No point of any body went farther than this since the reference."""
    most = 0.0
    for body, rim in enumerate(bodies.rims):
        way = length(pose[:3, body] - reference[:3, body])
        turn = 2.0 * min(1.0, length(pose[3:, body] - reference[3:, body]))
        most = max(most, way + turn * float(np.sqrt((rim**2).sum(axis=1).max())))
    return most


def keep_out(bodies: Bodies, pose: Array, motion: Array, liquid: tuple[Array, Array, Array]) -> int:
    """Put liquid (position, velocity, mass) that got into a body back onto its surface; how many. What the liquid's
    momentum gains the body's loses.
    """
    position, velocity, mass = liquid
    d, hits = len(position), 0
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
            _bounce(bodies, body, (pose, motion), (position[:, i], velocity[:, i], float(mass[i]), out))
        hits += len(inside)
    return hits


def _bounce(bodies: Bodies, body: int, state: tuple[Array, Array], particle: tuple[Array, Array, float, Array]) -> None:
    """End their approach, as of two bodies that stick: the lighter one gives way."""
    pose, motion = state
    x, v, mass, out = particle
    arm, normal = np.pad(x, (0, 3 - len(x))) - pose[:3, body], np.pad(out, (0, 3 - len(out)))
    surface = motion[:3, body] + np.cross(motion[3:, body], arm)
    approach = dot(v - surface[: len(v)], out)
    if approach < 0.0:
        turning = np.cross(product(inverse_inertia_of(bodies, body, pose), np.cross(arm, normal)), arm)
        impulse = -approach / (1.0 / mass + 1.0 / bodies.mass[body] + dot(normal, turning)) * normal
        v += impulse[: len(v)] / mass
        give(bodies, body, state, (-impulse, arm))


def give(bodies: Bodies, body: int, state: tuple[Array, Array], impulse: tuple[Array, Any]) -> None:
    """Hand a body an impulse at an arm from its middle."""
    pose, motion = state
    inverse = inverse_inertia_of(bodies, body, pose)
    motion[:3, body] += impulse[0] / bodies.mass[body]
    motion[3:, body] += product(inverse, np.cross(impulse[1], impulse[0]))


def inverse_inertia_of(bodies: Bodies, body: int, pose: Array) -> Array:
    """(3, 3) of one body."""
    turn = rotations(pose[:, body : body + 1])[0]
    own = bodies.inertia[:, body]
    inverse = np.divide(1.0, own, out=np.zeros(3), where=own > 0.0)
    found: Array = product(turn * inverse, turn.T)
    return found
