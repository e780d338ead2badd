"""Frames of soft spheres: positions, states of contacts, and lists of contacts.

Frames contain contacts as arrays over spheres: each contact belongs to the row of its sphere with the lower number. By
default frames contain the narrowest gaps of a sphere, as scalars. With `films.output = "vectors"` they contain all
contacts, with image, force vectors and deflection, so that a force network, the balance of forces and the stress follow
from them.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ecume._portable import exp, log
from ecume.engine.cells import Integers
from ecume.laws.soft_contacts import DEFINITE, TANGENTIAL, TENSION
from ecume.models.invariants import DISSIPATED
from ecume.models.invariants import INJECTED as INJECTED_WORK
from ecume.models.soft.cell import STRAIN, TILT, WIDTH, Box
from ecume.models.soft.contacts.contact_list import wall_films
from ecume.models.soft.contacts.tree_search import box_in, image_indices, wrapped
from ecume.models.soft.contacts.walls import all_walls
from ecume.models.soft.integration.linear_solvers import begin_step
from ecume.models.soft.parameters import Contacts, Parameters
from ecume.models.soft.protocol import drive_at
from ecume.models.soft.report.energy_budget import (
    DRAG,
    FILMS,
    INJECTED,
    SIZE,
    elastic_energy,
    remote_energy,
    stake,
)
from ecume.models.soft.report.permeation_report import PORE, pressure_arrays, pressure_numbers
from ecume.models.soft.state import ACCEPTED, CLOCK, FAILED, FORCE_RESIDUAL, REJECTED, State, Step, Workspace
from ecume.models.soft.waiting import RUNNING, STATIONARY, rate_at
from ecume.scenes.soft import SIDES
from ecume.trajectories.frame import Frame
from ecume.units import Array, with_prefix

FAINT = 1e-3
"""The deflection, over the radius, below which the ratio of its parts is meaningless."""
LARGE = 0.1
"""Deflection over radius above which the contact laws are inaccurate."""


class Deflections(NamedTuple):
    """The contacts of a state; those with walls follow those of pairs."""

    pair: Integers
    """(C, 2) the spheres; at walls the sphere, and -1 less the wall"""
    radius: Array
    """(C,) m, the smaller one"""
    gap: Array
    normal: Array
    """(C,) m, the normal deflection, positive in tension"""
    tangential: Array
    """(C,) m, the magnitude of the tangential deflection"""
    vector: Array
    """(C, d) m"""

    @property
    def magnitude(self) -> Array:
        """The magnitude of the deflection over the radius."""
        return np.asarray(np.hypot(self.normal, self.tangential) / self.radius)


def deflections(parameters: Parameters, state: State) -> Deflections:
    """The deflections of all contacts."""
    pairs, walls = _of_pairs(parameters, state), _of_walls(parameters, state)
    return Deflections(*(np.concatenate(parts) for parts in zip(pairs, walls, strict=True)))


def _of_pairs(parameters: Parameters, state: State) -> Deflections:
    count, box = int(state.contacts[0]), box_in(parameters, state)
    pair, direction = state.pair[:count].copy(), state.direction[:count]
    gap, radius = exp(state.log_gap[:count]), parameters.radius[pair]
    reach = (radius.sum(axis=1) + gap)[:, None] * direction
    return _split(pair, radius.min(axis=1, initial=np.inf), gap, between(state, box) - reach, direction)


def between(state: State, box: Box) -> Array:
    """The vectors between the centers of all pairs in contact (C, d)."""
    count = int(state.contacts[0])
    pair, image = state.pair[:count], state.image[:count]
    vectors = state.position[pair[:, 1]] - state.position[pair[:, 0]] + image * box.sides
    vectors[:, 0] += box.tilt * image[:, 1]
    return np.asarray(vectors)


def _of_walls(parameters: Parameters, state: State) -> Deflections:
    first, wall = np.nonzero(wall_films(parameters, state))
    dimensions, radius = state.position.shape[1], parameters.radius[first]
    normal = -parameters.walls.surfaces.place[wall, :dimensions]
    gap = exp(state.wall_gap[first, wall])
    apart = state.wall[wall, :dimensions] - state.position[first] - radius[:, None] * state.slip[first, wall]
    pair = np.stack([first, -1 - wall], axis=1).astype(np.int64)
    return _split(pair, radius, gap, apart - (radius + gap)[:, None] * normal, normal)


def _split(pair: Integers, radius: Array, gap: Array, vector: Array, direction: Array) -> Deflections:
    normal = (vector * direction).sum(axis=1)
    tangential = np.linalg.norm(vector - normal[:, None] * direction, axis=1)
    return Deflections(pair, radius, gap, normal, tangential, vector)


def extremes(found: Deflections) -> dict[str, float]:
    """Numbers of a frame on the largest deflections, relative to the limits of the contact laws."""
    magnitude = found.magnitude
    loaded = magnitude > FAINT
    ratio = found.tangential[loaded] / np.maximum(np.abs(found.normal[loaded]), FAINT**2 * found.radius[loaded])
    return {
        "largest_deflection": float(magnitude.max(initial=0.0)),
        "largest_shear_ratio": float(ratio.max(initial=0.0)),
    }


def worst_contact(found: Deflections) -> str:
    """The contact with the largest deflection, and its values; empty without contacts."""
    if not len(found.radius):
        return ""
    at = int(np.argmax(found.magnitude))
    first, second = found.pair[at]
    other = f"sphere {second}" if second >= 0 else f"wall {-1 - second}"
    sign = "tension" if found.normal[at] > 0.0 else "compression"
    values = [
        f"gap {with_prefix(float(found.gap[at]), 'm', 3)}",
        f"normal deflection {abs(found.normal[at]) / found.radius[at]:.3g} radii in {sign}",
        f"tangential deflection {found.tangential[at] / found.radius[at]:.3g} radii",
    ]
    return f"the largest deflection is that of sphere {first} with {other}: {', '.join(values)}"


def is_beyond(found: Deflections) -> bool:
    """Whether a deflection is finite and beyond the range of the contact laws."""
    return bool((found.magnitude > LARGE).any() and np.isfinite(found.magnitude).all())


def remedy(found: Deflections, contacts: Contacts) -> str:
    """Suggested changes of the scene for contacts beyond the limits of their laws."""
    tangential, tension = list(TANGENTIAL)[contacts.tangential_law], list(TENSION)[contacts.tension_law]
    beyond = found.magnitude > LARGE
    stretched = bool((found.normal[beyond] > LARGE * found.radius[beyond]).any())
    sheared = bool((found.tangential[beyond] > DEFINITE * np.abs(found.normal[beyond])).any())
    if stretched and tension != "gap":
        return 'films hold stretched pairs together; set films.tension_law = "gap"'
    if sheared and tangential != "potential":
        return 'the secant law has lost its definite stiffness; set films.tangential_law = "potential"'
    if beyond.any():
        return "deflections exceed the range of the contact laws; reduce forces, shear rate or volume fraction"
    return "look for forces that the surfaces cannot balance, or set integration.tolerance lower"


SLOTS = {2: 8, 3: 16}
"""The default number of contacts that a frame lists for a sphere, by dimension: those with later spheres, the narrowest
gaps first.
"""
MOST = 1000
"""Components that an array of a trajectory can have for a particle."""
CONTACT_UNITS = {
    "gap": "m",
    "tension": "N",
    "shear": "N",
    "normal_force": "N",
    "tangential_force": "N",
    "deflection": "m",
}
UNLISTED = "unlisted_contacts"


def slots_of(parameters: Parameters) -> int:
    """The number of contacts that frames can list for each sphere."""
    dimensions, others = parameters.dimensions, max(len(parameters.radius) - 1, 1)
    if parameters.listed == "scalars":
        return min(SLOTS[dimensions], others)
    reach, smallest, largest = parameters.contacts.fade_to, parameters.radius.min(), parameters.radius.max()
    images = 2 if parameters.box.any() else 1
    if math.isinf(reach):
        return min(others, MOST)
    # At most as many of the smallest spheres as fill the shell within reach of the largest sphere.
    outer, inner = largest + 2.0 * smallest + reach, largest
    shell = (outer**dimensions - inner**dimensions) / smallest**dimensions
    return int(min(max(math.ceil(shell), 1), images * others, MOST))


def listed(parameters: Parameters, state: State, step: Step) -> tuple[dict[str, Array | Integers], int]:
    """The arrays of contacts, and the number of contacts that did not fit into them; -1 fills the remainder of
    `neighbor`.
    """
    first, count, slots = step.pairs.first, len(parameters.radius), slots_of(parameters)
    order = np.lexsort((step.log_gap, first))
    place = np.arange(len(first)) - np.searchsorted(first[order], first[order])
    fits = place < slots
    one, place = order[fits], place[fits]
    arrays: dict[str, Array | Integers] = {}
    for name, values in _columns(parameters, state, step).items():
        shape = (count, slots, *values.shape[1:])
        arrays[name] = np.full(shape, -1, np.int64) if name == "neighbor" else np.zeros(shape, values.dtype)
        arrays[name][first[one], place] = values[one]
    return arrays, int((~fits).sum())


def _columns(parameters: Parameters, state: State, step: Step) -> dict[str, Array | Integers]:
    """The values of all contacts, in their order."""
    d, force, direction = parameters.dimensions, step.responses.force, step.direction
    gap, tension = exp(step.log_gap), (force * direction).sum(axis=1)
    along = force - tension[:, None] * direction
    values: dict[str, Array | Integers] = {
        "neighbor": step.pairs.second,
        "gap": gap,
        "tension": tension,
        "shear": np.linalg.norm(along, axis=1),
    }
    if parameters.listed == "scalars":
        return values
    box = box_in(parameters, state)
    away, count = image_indices(state.position, box), int(state.contacts[0])
    image = state.image[:count] + away[step.pairs.second] - away[step.pairs.first]
    reach = (step.pairs.radius_sum + gap)[:, None] * direction[:, :d]
    return values | {
        "contact_image": image,
        "normal_force": tension[:, None] * direction[:, :d],
        "tangential_force": along[:, :d],
        "deflection": between(state, box) - reach,
    }


def widths(parameters: Parameters) -> dict[str, int]:
    """The number of values per sphere in each array of contacts."""
    slots, d = slots_of(parameters), parameters.dimensions
    scalars = dict.fromkeys(("neighbor", "gap", "tension", "shear"), slots)
    if parameters.listed == "scalars":
        return scalars
    return scalars | dict.fromkeys(("contact_image", "normal_force", "tangential_force", "deflection"), d * slots)


STRESS = {2: "N/m", 3: "Pa"}
"""The unit of stress: in a layer, force over length."""
VISCOSITY = {2: "N*s/m", 3: "Pa*s"}
LENGTHS = ("box_width", "box_height", "box_depth")
AXES = "xyz"
SIDE_NAMES = {place: name for name, place in SIDES.items()}
CLOSE = 0.1
"""The largest gap of neighbors in `coordination` and `mean_gap`, over the smaller radius."""
SIZE_WORK, STAKE = "size_work", "contact_work"
PREPARATION = ("preparation_time", "preparation_change")
UNITS = {
    "preparation_time": "s",
    "position": "m",
    "velocity": "m/s",
    "radius": "m",
    "angle": "rad",
    "spin": "rad/s",
    "image": "1",
    "elastic_energy": "J",
    "remote_energy": "J",
    "total_energy": "J",
    INJECTED_WORK: "J",
    DISSIPATED: "J",
    SIZE_WORK: "J",
    STAKE: "J",
    "smallest_gap": "m",
    "mean_gap": "m",
    "largest_tension": "N",
    "largest_compression": "N",
    **CONTACT_UNITS,
}


def observe(parameters: Parameters, state: State, scratch: Workspace) -> Frame:
    """The frame of this instant."""
    drive = drive_at(parameters.protocol, float(state.pace[CLOCK]))
    step, box = scratch.step, box_in(parameters, state)
    begin_step(parameters, step, drive)
    gap, beside = exp(step.log_gap), exp(state.wall_gap[wall_films(parameters, state)])
    tension = (step.responses.force * step.direction).sum(axis=1)
    contacts, unlisted = listed(parameters, state, step)
    arrays = {
        "position": wrapped(state.position, box),
        "velocity": velocity_at_home(parameters, state, box),
        "radius": parameters.radius.copy(),
        "species": parameters.species.copy(),
        **contacts,
        **_spinning(state),
        **pressure_arrays(step),
        **({"image": image_indices(state.position, box)} if parameters.box.any() else {}),
    }
    numbers = {
        "elastic_energy": (held := elastic_energy(parameters.contacts, step)),
        "smallest_gap": float(np.append(gap, beside).min(initial=np.inf)),
        **_neighbors(parameters, step),
        **_wall_numbers(parameters, state, step),
        **pressure_numbers(step.permeation, wall_names(parameters)),
        "largest_tension": float(tension.max(initial=0.0)),
        "largest_compression": float((-tension).max(initial=0.0)),
        **extremes(deflections(parameters, state)),
        "reduced_tension": _reduced(step, tension),
        UNLISTED: float(unlisted),
        "load": drive.load,
        "imbalance": float(state.pace[FORCE_RESIDUAL]),
        "contacts": float(len(tension)),
        "time_steps": float(state.tally[ACCEPTED]),
        "rejected_steps": float(state.tally[REJECTED] + state.tally[FAILED]),
    }
    numbers |= _budget(parameters, state, step, held) | _preparation_numbers(state)
    if not parameters.box[: parameters.dimensions].all():
        sides = _sides(box)
        units = UNITS | _wall_units(numbers) | dict.fromkeys(sides, "m")
        units |= dict.fromkeys((name for name in {**arrays, **numbers} if PORE in name), STRESS[parameters.dimensions])
        return Frame(float(state.pace[CLOCK]), arrays, numbers | sides, units)
    volume = float(np.prod(box.sides))
    parts = stresses(parameters, step, gap, volume)
    tensor, rate = np.sum(list(parts.values()), axis=0), float(state.cell_rate[STRAIN])
    numbers |= _rate_numbers(parameters, state)
    numbers |= (
        _box_numbers(parameters, box, float(state.cell[STRAIN])) | _stress_numbers(tensor, rate) | _components(parts)
    )
    return Frame(float(state.pace[CLOCK]), arrays, numbers, UNITS | _box_units(parameters.dimensions, numbers))


def main_stresses(parameters: Parameters, state: State, scratch: Workspace) -> tuple[float, float]:
    """The shear stress and the normal stress of a frame at this instant."""
    step, box = scratch.step, box_in(parameters, state)
    begin_step(parameters, step, drive_at(parameters.protocol, float(state.pace[CLOCK])))
    parts = stresses(parameters, step, exp(step.log_gap), float(np.prod(box.sides)))
    numbers = _stress_numbers(np.sum(list(parts.values()), axis=0), float(state.cell_rate[STRAIN]))
    return numbers["shear_stress"], numbers["normal_stress"]


def _rate_numbers(parameters: Parameters, state: State) -> dict[str, float]:
    """The rate to which a frame belongs, of those that are held until the stress is stationary, and how many have
    ended; none in scenes without them.
    """
    reached = state.rate_reached
    if not len(reached):
        return {}
    return {
        "rate_step": float(rate_at(parameters.protocol, float(state.pace[CLOCK]))),
        "rates_left": float((reached == RUNNING).sum()),
        "rates_stationary": float((reached == STATIONARY).sum()),
    }


def _reduced(step: Step, tension: Array) -> float:
    """The largest tension between two spheres over E R^2, where R is twice the reduced radius."""
    scale = step.pairs.modulus * (2.0 * step.pairs.reduced_radius) ** 2
    return float((tension / scale).max(initial=0.0))


def _spinning(state: State) -> dict[str, Array | Integers]:
    """Orientations and spins of spheres that rotate: angles in a layer, quaternions in 3D."""
    if state.spin.shape[1] == 0:
        return {}
    if state.spin.shape[1] == 1:
        return {"angle": state.orientation[:, 0].copy(), "spin": state.spin[:, 0].copy()}
    return {"orientation": state.orientation.copy(), "spin": state.spin.copy()}


def velocity_at_home(parameters: Parameters, state: State, box: Box) -> Array:
    """The velocity of the periodic copy within the box, averaged over the last step: images above and below move with
    the shear, and all images with the sides.
    """
    velocity = state.velocity.copy()
    if not parameters.box.any():
        return velocity
    away, rate = image_indices(state.position, box), state.cell_rate
    velocity -= away * box.sides * rate[WIDTH : WIDTH + velocity.shape[1]]
    velocity[:, 0] -= away[:, 1] * (rate[TILT] * box.sides[0] + rate[WIDTH] * box.tilt)
    return velocity


def acts_across(parameters: Parameters) -> bool:
    """Whether there can be a long-range force between surfaces, from the scene or from user laws."""
    return parameters.laws.remote.acts or bool(parameters.user_forces)


def _budget(parameters: Parameters, state: State, step: Step, held: float) -> dict[str, float]:
    """The energy budget (J): stored, injected and dissipated energy, and the work of the surface law.

    Runs of earlier versions have no energy budget.
    """
    if not len(state.budget):
        return {}
    remote = {"remote_energy": remote_energy(parameters.contacts, step)} if acts_across(parameters) else {}
    numbers = {"total_energy": held + sum(remote.values()), INJECTED_WORK: state.budget[INJECTED]}
    numbers |= {DISSIPATED: state.budget[FILMS] + state.budget[DRAG], SIZE_WORK: state.budget[SIZE]}
    numbers |= {STAKE: stake(step)}
    return remote | {name: float(value) for name, value in numbers.items()}


def _preparation_numbers(state: State) -> dict[str, float]:
    """The result of the preparation: its duration, and the last change of contact forces relative to these."""
    return dict(zip(PREPARATION, map(float, state.prepared), strict=False))


def wall_names(parameters: Parameters) -> list[str]:
    """The side of each wall."""
    inward = parameters.walls.surfaces.place
    return [SIDE_NAMES[int(np.flatnonzero(normal)[0]), -float(normal.sum())] for normal in inward]


def _wall_numbers(parameters: Parameters, state: State, step: Step) -> dict[str, float]:
    """Positions of walls, and forces of the spheres on them: `top_y`, `top_force_x` and so on.

    Along a wall, the position is its displacement.
    """
    walls, dimensions = parameters.walls.surfaces, parameters.dimensions
    force = np.zeros((len(walls.kind), 3))
    touches = all_walls(step.walls).touches
    np.add.at(force, touches.wall, -touches.force)
    names = wall_names(parameters)
    places = {f"{name}_{AXES[k]}": float(state.wall[w, k]) for w, name in enumerate(names) for k in range(dimensions)}
    return places | {
        f"{name}_force_{AXES[k]}": float(force[w, k]) for w, name in enumerate(names) for k in range(dimensions)
    }


def _wall_units(numbers: Mapping[str, float]) -> dict[str, str]:
    walls = tuple(SIDE_NAMES.values())
    return {name: "N" if "_force_" in name else "m" for name in numbers if name.startswith(walls)}


def stresses(parameters: Parameters, step: Step, gap: Array, volume: float) -> dict[str, Array]:
    """The stress (1/V) sum of F_ij X_ij over contacts, tension positive, in three parts: of squeezed films, of sheared
    films, and of long-range forces. The surfaces bear the sum, since they are in series with the films.
    """
    dimensions = parameters.dimensions
    between = step.bodies.position[step.pairs.second] - step.bodies.position[step.pairs.first]
    between = between + step.pairs.offset[:, :dimensions]
    normal = step.direction[:, :dimensions]
    force = step.responses.force[:, :dimensions]
    pull = (force * normal).sum(axis=1)[:, None] * normal
    push = _remote_forces(parameters, step, gap)[:, None] * normal
    parts = {"squeeze": pull + push, "sliding": force - pull}
    if acts_across(parameters):
        parts["remote"] = -push
    return {name: np.einsum("ca,cb->ab", part, between) / volume for name, part in parts.items()}


def _remote_forces(parameters: Parameters, step: Step, gap: Array) -> Array:
    """The long-range repulsion in each film (N)."""
    law = _remote_law(parameters, parameters.laws.remote.force)
    built_in = np.array([law(h, r) for h, r in zip(gap, step.pairs.reduced_radius, strict=True)])
    return np.asarray(built_in + step.pairs.across[:, 0])


def _remote_law(parameters: Parameters, law: Callable[..., float]) -> Callable[[float, float], float]:
    """A law of `REMOTE` as a function of gap and reduced radius, with the scene's constants."""
    names = list(inspect.signature(law).parameters)
    given = {name: getattr(parameters.contacts, name) for name in names if hasattr(parameters.contacts, name)}
    if "reduced_radius" in names:
        return lambda gap, radius: law(gap, radius, **given)
    return lambda gap, radius: law(gap, **given)


def _neighbors(parameters: Parameters, step: Step) -> dict[str, float]:
    """The number of close neighbors, and the geometric mean of their gaps."""
    radius = np.minimum(parameters.radius[step.pairs.first], parameters.radius[step.pairs.second])
    close = step.log_gap[step.log_gap < log(CLOSE * radius)]
    mean = float(exp(close.mean())) if len(close) else math.nan
    return {"coordination": 2.0 * len(close) / len(parameters.radius), "mean_gap": mean}


def _box_numbers(parameters: Parameters, box: Box, strain: float) -> dict[str, float]:
    dimensions, radius = parameters.dimensions, parameters.radius
    filled = np.pi * radius**2 if dimensions == 2 else 4.0 / 3.0 * np.pi * radius**3
    return {
        "strain": strain,
        **_sides(box),
        "box_tilt": box.tilt,
        "volume_fraction": float(filled.sum() / np.prod(box.sides)),
    }


def _sides(box: Box) -> dict[str, float]:
    """The sides of the box along the axes on which it is periodic."""
    return {name: float(side) for name, side in zip(LENGTHS, box.sides, strict=False) if side > 0.0}


def _stress_numbers(tensor: Array, rate: float) -> dict[str, float]:
    """Components and invariants of a stress; the viscosity is NaN without shear.

    The shear stress is that of the force along x on the top, sum of F_x Y, which differs from that along y for spheres
    without spin.
    """
    shear = float(tensor[0, 1])
    pressure = -float(np.trace(tensor)) / len(tensor)
    return {
        "pressure": pressure,
        "pressure_sign": float(np.sign(pressure)),
        "shear_stress": shear,
        "normal_stress": -float(tensor[1, 1]),
        "strain_rate": rate,
        "viscosity": shear / rate if rate != 0.0 else math.nan,
    }


def _components(parts: Mapping[str, Array]) -> dict[str, float]:
    """The components of each part of the stress: `stress_squeeze_xy`, the force along x across a plane normal to y, and
    so on.
    """
    return {
        f"stress_{name}_{AXES[i]}{AXES[j]}": float(value)
        for name, part in parts.items()
        for (i, j), value in np.ndenumerate(part)
    }


def _box_units(dimensions: int, numbers: Mapping[str, float]) -> dict[str, str]:
    stressed = [name for name in numbers if name.startswith("stress_")]
    units = dict.fromkeys(("pressure", "shear_stress", "normal_stress", *stressed), STRESS[dimensions])
    units |= dict.fromkeys(LENGTHS[:dimensions], "m") | {"box_tilt": "m"}
    return units | {"strain_rate": "1/s", "viscosity": VISCOSITY[dimensions]}
