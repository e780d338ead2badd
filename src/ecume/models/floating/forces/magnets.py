"""Magnetic floats: repelling vertical dipoles, and moments in a uniform field that may oscillate.

Floats in a uniform magnetic field that may oscillate: induced moments along the field, and permanent vertical ones. The
force on j by i at the distance l in the direction n is F = (3 mu_0/(4 pi l^4)) [(m_i.m_j - 5 (m_i.n)(m_j.n)) n +
(m_i.n) m_j + (m_j.n) m_i] [jackson1999, par. 5.7]. The surface supports the vertical component. At given positions the
energy is a polynomial of second degree in the field; its coefficients are summed with the forces, and its change with
the field is the injected work.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ecume._jit import admit, compiled, compiled_inside
from ecume.engine.cells import Integers
from ecume.engine.contact.contacts import apart
from ecume.engine.neighbors import NeighborLists, Slots
from ecume.engine.walls.surfaces import farthest
from ecume.laws import pair_laws
from ecume.laws.pair_laws import Dipoles, dipole_energy, dipole_force, dipole_strength, induced_moment
from ecume.models.floating.forces.pair_forces import add_from_slots, pairs_of, sum_pair_forces
from ecume.models.floating.options import Built, scene_error
from ecume.models.floating.parameters import (
    CAPILLARY_LENGTH,
    CUTOFF,
    STRENGTH,
    SURFACE_TENSION,
    WORK,
    Parameters,
    State,
    Workspace,
)
from ecume.models.floating.setup.kinds import distinct_kinds, moments_of
from ecume.models.floating.shaped.shapes import inner_radius
from ecume.models.floating.time_integration.step_size import RAFT_NEIGHBORS
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


admit(pair_laws)


class DipoleMoments(NamedTuple):
    """Magnetic moments, the constants of this interaction."""

    moment: Array
    """(N,) A m^2, upward"""
    pair: Array
    """the law's constants, the first of them as in `parameters.pack_pair`: strength of two unit moments, cutoff"""


class SortedMoments(NamedTuple):
    """Workspace in the order of the slots."""

    moment: Array
    force: Array
    """(2, N) N"""


def make_dipole_moments(moment: Array, cutoff: float) -> DipoleMoments:
    """Return moments that act up to a cutoff (m)."""
    pair = np.zeros(max(STRENGTH, CUTOFF, SURFACE_TENSION) + 1)
    pair[STRENGTH], pair[CUTOFF], pair[CAPILLARY_LENGTH] = dipole_strength(1.0, 1.0), cutoff, 1.0
    return DipoleMoments(np.asarray(moment, np.float64), pair)


def make_sorted_moments(
    part: DipoleMoments, parameters: Parameters, state: State, workspace: Workspace
) -> SortedMoments:
    """Return the workspace."""
    return SortedMoments(np.zeros_like(part.moment), np.zeros((2, len(part.moment))))


@compiled
def sort_moments(part: DipoleMoments, scratch: SortedMoments, parameters: Parameters, lists: NeighborLists) -> None:
    """Copy moments into the order of the slots, after each rebuild of the neighbor lists."""
    order = lists.cells.order
    for slot in range(len(order)):
        scratch.moment[slot] = part.moment[order[slot]]


@compiled
def dipole_forces(
    part: DipoleMoments,
    scratch: SortedMoments,
    parameters: Parameters,
    position: Array,
    lists: NeighborLists,
    force: Array,
) -> None:
    """Add the forces of all pairs of dipoles."""
    sum_pair_forces(
        Dipoles(part.pair[STRENGTH]), pairs_of(lists.rows), (scratch.moment, scratch.moment), part.pair, scratch.force
    )
    add_from_slots(lists.cells.order, scratch.force, force)


def dipole_energies(
    part: DipoleMoments, scratch: SortedMoments, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """The energy of all pairs of dipoles (J)."""
    rows = workspace.lists.rows
    listed = rows.first, rows.neighbor, workspace.lists.cells.order, rows.periods
    return float(sum_of_dipole_energies(state.position, part, listed)), 0.0


@compiled
def sum_of_dipole_energies(
    position: Array, part: DipoleMoments, listed: tuple[Integers, Slots, Integers, Array]
) -> float:
    """The energies (J) of all pairs within the cutoff, each minus its value at the cutoff."""
    first, neighbor, order, periods = listed
    moment, cutoff, total = part.moment, part.pair[CUTOFF], 0.0
    for slot in range(len(order)):
        i, own = order[slot], 0.0
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            x, y = apart(position, i, j, periods)
            distance = math.sqrt(x * x + y * y)
            if i < j and 0.0 < distance < cutoff:
                strength = dipole_strength(moment[i], moment[j])
                own += dipole_energy(distance, strength) - dipole_energy(cutoff, strength)
        total += own
    return total


def dipoles_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the dipoles of a scene. Two touching floats act as a spring of stiffness 4 F/l; a float has at most six
    neighbors.
    """
    moment = moments_of(scene)
    radius, walls = parameters.floats.radius, parameters.walls
    # Centers of elongated floats are closer than two radii where they touch.
    narrow = [inner_radius(kind.figure.skeleton) for kind in distinct_kinds(scene)[0] if kind.figure is not None]
    touching = 2.0 * min([float(radius.min()), *narrow])
    across = 2.0 * farthest(walls)
    cutoff = min(touching / math.sqrt(scene.interaction.accuracy), across)
    strongest = float(np.abs(moment).max())
    at_contact = dipole_force(touching, dipole_strength(strongest, strongest))
    spring, floats = 2.0 * RAFT_NEIGHBORS * 4.0 * at_contact / touching, parameters.floats
    shortest_time = float(np.min(np.sqrt(floats.mass / spring)))
    if not parameters.scheme.inertia:
        shortest_time = float(np.min(floats.mass / floats.relaxation_time)) / spring
    return Built(make_dipole_moments(moment, cutoff), shortest_time, reach=cutoff)


PER_PERIOD = 100.0
"""Time steps in a period of the field, at least."""
CHANGES = 10
"""Coefficients of the energy: of B_x^2, B_y^2, B_z^2, B_x B_y, B_x B_z, B_y B_z, B_x, B_y, B_z, 1."""


class MagneticField(NamedTuple):
    """Constants of the field and of the floats."""

    constant: Array
    """(3,) T"""
    amplitude: Array
    """(3,) T"""
    turning: float
    """rad/s"""
    phase: Array
    """(3,) rad"""
    induced: Array
    """(N,) A m^2/T"""
    permanent: Array
    """(N,) A m^2, upward"""
    strength: float
    """mu_0/(4 pi)"""
    cutoff: float
    """m"""


class MagneticScratch(NamedTuple):
    """The field at present and one step earlier, and the energy as a polynomial of the field."""

    field: Array
    """(2, 3) T: now, and at the beginning of the step"""
    energy: Array
    """(10,) J by powers of T: see `CHANGES`"""


def make_magnetic_scratch(
    part: MagneticField, parameters: Parameters, state: State, workspace: Workspace
) -> MagneticScratch:
    """Return the workspace with the field at the time of the state."""
    own = MagneticScratch(np.zeros((2, 3)), np.zeros(CHANGES))
    set_field(part, own, int(state.step[0]) * parameters.time_step)
    return own


@compiled
def set_field(part: MagneticField, scratch: MagneticScratch, time: float) -> None:
    """Store the previous field, and compute the field at a time."""
    for axis in range(3):
        scratch.field[1, axis] = scratch.field[0, axis]
        swing = part.amplitude[axis] * math.cos(part.turning * time + part.phase[axis])
        scratch.field[0, axis] = part.constant[axis] + swing


@compiled_inside
def energy_in(energy: Array, field: Array) -> float:
    """The polynomial of the energy (J)."""
    x, y, z = field[0], field[1], field[2]
    squares = energy[0] * x * x + energy[1] * y * y + energy[2] * z * z
    products = energy[3] * x * y + energy[4] * x * z + energy[5] * y * z
    return float(squares + products + energy[6] * x + energy[7] * y + energy[8] * z + energy[9])


@compiled
def magnetic_forces(
    part: MagneticField,
    scratch: MagneticScratch,
    parameters: Parameters,
    position: Array,
    lists: NeighborLists,
    force: Array,
) -> None:
    """Add the forces of all pairs within the cutoff, and sum the coefficients of the energy."""
    rows, order = lists.rows, lists.cells.order
    first, neighbor, periods = rows.first, rows.neighbor, rows.periods
    x, y, z = scratch.field[0, 0], scratch.field[0, 1], scratch.field[0, 2]
    for k in range(CHANGES):
        scratch.energy[k] = 0.0
    for slot in range(len(order)):
        i = order[slot]
        a, p = part.induced[i], part.permanent[i]
        for place in range(first[slot], first[slot + 1]):
            j = order[neighbor[place]]
            if not i < j:
                continue
            dx, dy = apart(position, i, j, periods)
            square = dx * dx + dy * dy
            if not 0.0 < square < part.cutoff * part.cutoff:
                continue
            distance = math.sqrt(square)
            nx, ny, b, q = dx / distance, dy / distance, part.induced[j], part.permanent[j]
            add_energy(scratch.energy, part.strength / (square * distance), (nx, ny), (a, p), (b, q))
            scale = 3.0 * part.strength / (square * square)
            along = x * nx + y * ny
            product = a * b * (x * x + y * y) + (a * z + p) * (b * z + q)
            radial = scale * (product - 5.0 * a * b * along * along)
            sideways = scale * 2.0 * a * b * along
            fx, fy = radial * nx + sideways * x, radial * ny + sideways * y
            force[j, 0] += fx
            force[j, 1] += fy
            force[i, 0] -= fx
            force[i, 1] -= fy


@compiled_inside
def add_energy(
    energy: Array, scale: float, n: tuple[float, float], one: tuple[float, float], other: tuple[float, float]
) -> None:
    """Add the coefficients of a pair, those of its energy (m_i.m_j - 3 (m_i.n)(m_j.n)) times `scale`."""
    a, p = one
    b, q = other
    induced = scale * a * b
    energy[0] += induced * (1.0 - 3.0 * n[0] * n[0])
    energy[1] += induced * (1.0 - 3.0 * n[1] * n[1])
    energy[2] += induced
    energy[3] -= induced * 6.0 * n[0] * n[1]
    energy[8] += scale * (a * q + b * p)
    energy[9] += scale * p * q


@compiled
def renew_field(
    part: MagneticField, scratch: MagneticScratch, parameters: Parameters, state: State, first: bool
) -> None:
    """Before a step, advance the field, and add half of the work of its change at the initial positions; after the
    step, add the other half.
    """
    if first:
        set_field(part, scratch, (state.step[0] + 1) * parameters.time_step)
    change = energy_in(scratch.energy, scratch.field[0]) - energy_in(scratch.energy, scratch.field[1])
    state.tally[WORK] += 0.5 * change


def magnetic_energy(
    part: MagneticField, scratch: MagneticScratch, parameters: Parameters, state: State, workspace: Workspace
) -> tuple[float, float]:
    """The energy of all pairs (J) in the field of this time."""
    present = MagneticScratch(scratch.field.copy(), np.zeros(CHANGES))
    set_field(part, present, int(state.step[0]) * parameters.time_step)
    magnetic_forces(
        part, present, parameters._replace(parts=()), state.position, workspace.lists, np.zeros_like(state.position)
    )
    return float(energy_in(present.energy, present.field[0])), 0.0


def magnetic_field_of(parameters: Parameters, scene: FloatingScene) -> Built:
    """Return the magnetic field of a scene. Two touching floats act as a spring of stiffness 4 F/l, as for dipoles."""
    given, floats = scene.magnetic_field, parameters.floats
    assert given is not None  # noqa: S101  # for the type checker: the scene has chosen it
    names = [name for name, *_ in scene.kinds]
    if unknown := [name for name in given.species if name not in names]:
        raise scene_error(
            "magnetic_field.species", f"got {unknown[0]!r}; expected names among {', '.join(map(repr, names))}"
        )
    if any(one.disc is not None for one in scene.given) and given.susceptibility > 0.0:
        raise scene_error("magnetic_field.susceptibility", "induced moments are those of spheres; got a disc")
    chosen = np.array([not given.species or names[number] in given.species for number in floats.species], np.float64)
    induced = np.array([induced_moment(r, given.susceptibility, 1.0) for r in floats.radius.tolist()]) * chosen
    permanent, turning = moments_of(scene), 2.0 * math.pi * given.frequency
    constant, amplitude = np.array(given.constant), np.array(given.amplitude)
    touching = 2.0 * float(floats.radius.min())
    cutoff = touching / math.sqrt(scene.interaction.accuracy)
    part = MagneticField(
        constant, amplitude, turning, np.array(given.phase), induced, permanent, dipole_strength(1.0, 1.0), cutoff
    )
    highest = float(np.linalg.norm(np.abs(constant) + np.abs(amplitude)))
    shortest_time = shortest_time_at_contact(parameters, induced * highest + np.abs(permanent))
    if np.any(amplitude):
        shortest_time = min(shortest_time, 20.0 * 2.0 * math.pi / turning / PER_PERIOD)
    return Built(part, shortest_time, reach=cutoff)


def shortest_time_at_contact(parameters: Parameters, moment: Array) -> float:
    """The shortest time scale (s) of two touching floats with these moments, over all pairs of kinds."""
    floats, shortest_time = parameters.floats, math.inf
    friction = floats.mass / floats.relaxation_time
    kinds = np.unique(np.stack([floats.radius, moment, floats.mass, friction]), axis=1).T.tolist()
    for radius, own, mass, drag in kinds:
        for other_radius, other, _, _ in kinds:
            distance = radius + other_radius
            at_contact = 6.0 * dipole_strength(own, other) / distance**4
            spring = 2.0 * RAFT_NEIGHBORS * 4.0 * at_contact / distance
            if spring > 0.0:
                shortest_time = min(
                    shortest_time, math.sqrt(mass / spring) if parameters.scheme.inertia else drag / spring
                )
    return shortest_time


def magnetic_lines(part: MagneticField, parameters: Parameters) -> list[tuple[str, str, str]]:
    """The rows of `ecume check`: the induced moment, and the mutual induction of two touching spheres."""
    volume = 4.0 / 3.0 * math.pi * parameters.floats.radius**3
    effective = float(np.max(part.induced * 4.0 * math.pi * part.strength / volume))
    # The field of an induced moment on the line of centers at the distance 2 R, over the inducing field.
    mutual = effective / 12.0
    return [
        ("induced moment", f"{float(part.induced.max()):.3g} A m^2/T", f"effective susceptibility {effective:.3g}"),
        ("mutual induction", f"up to {100.0 * mutual:.2g} %", "of touching spheres; not included"),
    ]
