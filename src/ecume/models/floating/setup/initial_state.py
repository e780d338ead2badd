"""The first state: floats at given positions, on lattices and rings, or at random; and the periodic cell.

The smallest periodic cell is that in which nearest images are sufficient: each float interacts with the nearest image
of every other float. That is the sum over all images if no force reaches farther than half of the shorter side. Beyond
the cutoff the attraction decays as K1, exponentially: a cell that is twice as wide as the cutoff omits no more than
`interaction.accuracy` allows.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume._jit import require_threads
from ecume.engine.cells import Integers, into_box, no_periods, periods_of
from ecume.engine.contact import contacts
from ecume.engine.neighbors import build, make_lists
from ecume.engine.placement import place_at_random
from ecume.engine.walls import Walls, rings
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws import capillarity
from ecume.models.floating.contacts.candidates import list_candidates
from ecume.models.floating.contacts.contact_models import contacts_of, gaps_between
from ecume.models.floating.forces.barrier import walls_at_start
from ecume.models.floating.forces.interactions import interactions_of
from ecume.models.floating.forces.pair_forces import row_of
from ecume.models.floating.options import Built, Option, scene_error
from ecume.models.floating.parameters import CAPILLARY_LENGTH, WORK, Parameters, State, is_driven, make_state
from ecume.models.floating.setup.overlaps import KEPT, SLIGHT, separated
from ecume.models.floating.setup.places import given_places, region_of
from ecume.models.floating.time_integration.integration import WIDEST, inertia_of
from ecume.models.layouts import Layout
from ecume.units import Array, with_prefix

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from ecume.scenes.floating import FloatingScene, FloatRow


CELL = Option(slot="boundary", path="cell", name="a periodic cell", gives=frozenset({"bounded", "outer walls"}))
OPEN = Option(slot="boundary", path="dish", name="an infinite surface", gives=frozenset({"open", "outer walls"}))
DISH = replace(OPEN, name="a dish", gives=frozenset({"open", "bounded", "outer walls"}))
RING = replace(OPEN, name="a ring", gives=frozenset({"open", "bounded"}))
GRADIENT = Option(
    slot="flow gradient", path="flow", name="a flow with a gradient",
    needs={"open": "its velocity differs on opposite borders of a cell"},
)  # fmt: skip


def boundary_of(scene: FloatingScene) -> list[Option]:
    """The boundary of a scene, and a flow that is not uniform, as options."""
    flow = scene.flow
    gradient = flow is not None and bool(
        flow.shear_rate or flow.rotation_rate or flow.extension_rate or flow.nodes is not None or flow.field is not None
    )
    around = OPEN if scene.dish is None else DISH if scene.dish.inner_radius is None else RING
    return [CELL if scene.cell is not None else around, *([GRADIENT] if gradient else [])]


def periods_in(scene: FloatingScene) -> Array:
    """The periods of the scene's cell; zero without a cell."""
    return no_periods(2) if scene.cell is None else periods_of(scene.sides)


class Range(NamedTuple):
    """The range of a force of the scene (m), and a hint on how to reduce it."""

    name: str
    reach: float
    hint: str


def require_room(parameters: Parameters, scene: FloatingScene, rows: Iterable[tuple[Any, Built]]) -> None:
    """Raise SceneError if the cell is so small that a float interacts with several images of another."""
    if scene.cell is None:
        return
    half = 0.5 * float(parameters.periods[0].min())
    ranges = [_contact_range(parameters), *_pair_range(parameters, half)]
    ranges += [_part_range(row, built, parameters, half) for row, built in rows if built.reach > 0.0]
    longest = max(ranges, key=lambda each: each.reach)
    if longest.reach > half:
        raise scene_error(
            "cell.size",
            f"got {with_prefix(2.0 * half, 'm')} as the shorter side; expected at least "
            f"{with_prefix(_rounded_up(2.0 * longest.reach, 4), 'm')}: {longest.name} reaches "
            f"{with_prefix(longest.reach, 'm')}, and images farther than half a side are omitted{longest.hint}",
        )


COARSEST_ACCURACY = 0.1
"""The largest `interaction.accuracy` of a scene."""


def _contact_range(parameters: Parameters) -> Range:
    return Range("a contact of the largest floats", 2.0 * float(parameters.floats.radius.max()), "")


def _pair_range(parameters: Parameters, half: float) -> list[Range]:
    """The range of the pair law, with a hint on the part of the attraction that a cutoff at half a side would
    neglect.
    """
    if not row_of(parameters).has_force:
        return []
    length, contact = float(parameters.pair[CAPILLARY_LENGTH]), 2.0 * float(parameters.floats.radius.max())
    omitted = capillarity.neglected_fraction(half / length, contact / length)
    if omitted <= 0.0:  # in cells far wider than the range of all forces
        return [Range("the attraction", parameters.cutoff, "")]
    needed = _rounded_up(omitted, 2)
    if needed > COARSEST_ACCURACY:
        hint = ' (interaction.law = "none" leaves the attraction out, where it is negligible)'
        return [Range("the attraction", parameters.cutoff, hint)]
    hint = (
        f" (interaction.accuracy = {needed:g} would accept this cell: that fraction of the attraction "
        "at a raft's edge would be omitted)"
    )
    return [Range("the attraction", parameters.cutoff, hint)]


def _part_range(row: Any, built: Built, parameters: Parameters, half: float) -> Range:
    """The range of a further force: of magnets according to the accuracy, of films according to their cutoff."""
    if row.path == "hydrodynamics.lubrication":
        return Range("a film", built.reach, " (a smaller hydrodynamics.lubrication.cutoff shortens the films)")
    touching = 2.0 * float(parameters.floats.radius.min())
    accuracy = _rounded_up((touching / half) ** 2, 2)
    return Range(row.name, built.reach, f" (interaction.accuracy = {accuracy:g} would accept this cell)")


def _rounded_up(value: float, digits: int) -> float:
    unit = 10.0 ** (math.floor(math.log10(value)) + 1 - digits)
    return float(f"{math.ceil(value / unit * (1.0 - 1e-12)) * unit:.{digits}g}")


TOUCHING = 1e-3
"""Overlaps up to this fraction of a radius are accepted: a scene may start from a raft of another run, whose floats
overlap slightly.
"""

MOST_FAULTS = 20
TURNS = 7
"""The seed offset between random angles and random positions."""


def start(scene: FloatingScene, parameters: Parameters) -> State:
    """Return the state at time 0. Raises SceneError if floats overlap, are outside, or do not fit."""
    parameters = parameters._replace(walls=walls_at_start(parameters.walls, scene.dish))
    places = given_places(scene)
    places.position[:] = into_box(places.position, parameters.periods)
    free = np.isnan(places.position[:, 0])
    if _are_hard(parameters):
        places.position[~free] = separated(
            places.position[~free], parameters.floats.radius[~free], parameters.periods, parameters.walls,
            parameters.slop,
        )  # fmt: skip
    if contacts_of(parameters).gaps is not None:
        _check_shapes(scene, parameters, places.position, np.flatnonzero(~free))
    else:
        _check(scene, parameters, places.position, np.flatnonzero(~free).astype(np.int64))
    if np.any(free):
        radius = parameters.floats.radius
        taken = places.position[~free], radius[~free]
        try:
            places.position[free] = place_at_random(radius[free], region_of(parameters), taken, scene.seed)
        except BadInput as error:
            raise SceneError([Fault("particles", str(error))]) from None
    state = with_angles(with_parts(make_state(places.position, places.velocity), parameters), scene, parameters)
    opened = contacts_of(parameters).separated
    if opened is not None and not np.all(free):
        _move_apart(opened, parameters, state)
    return state


def _move_apart(opened: Callable[..., tuple[Array, Array]], parameters: Parameters, state: State) -> None:
    """Move and rotate shapes that overlap by more than contacts tolerate; all others are unchanged to the bit."""
    part, at = parameters.parts.contacts, (state.position, state.turning[:, 0])
    near = gaps_between(parameters, *at, 2.0 * TOUCHING * float(parameters.floats.radius.max()))
    pairs = [row for row in near if not parameters.passing or row[1] >= len(state.position)]
    if any(gap < -KEPT * parameters.slop for _, _, gap in pairs):
        state.position[:], state.turning[:, 0] = opened(part, parameters, at, pairs)


def _are_hard(parameters: Parameters) -> bool:
    """Whether round floats may not overlap."""
    contacts = contacts_of(parameters)
    return not parameters.passing and not contacts.stores_overlaps and contacts.gaps is None


def layout(scene: FloatingScene, parameters: Parameters, state: State) -> Layout:
    """The arrays of a state of this scene. Stored contacts are only compared with detected ones, and not used as
    indices. States of earlier versions do not record injected work, which only driven scenes need.
    """
    zeros = np.zeros((len(parameters.floats.radius), 2))
    blank = with_angles(with_parts(make_state(zeros, zeros), parameters), scene, parameters)
    if state.tally.size == WORK and not is_driven(parameters):
        blank = blank._replace(tally=blank.tally[:WORK])
    ranges = {"touches": (0, len(blank.touching)), "skin": (0.0, WIDEST * parameters.skin)}
    return Layout(blank, ranges)


def with_parts(state: State, parameters: Parameters) -> State:
    """Return the state with the arrays of all parts."""
    for part, row in interactions_of(parameters):
        state = row.state(part, state)
    return contacts_of(parameters).state(parameters.parts.contacts, state)


def with_angles(state: State, scene: FloatingScene, parameters: Parameters) -> State:
    """Return the state with angles for floats that turn, given or random."""
    turns = inertia_of(parameters) is not None
    if len(state.active) and scene.waves is None:
        state = state._replace(active=_with_headings(state.active, scene, turns))
    if not turns:
        return state
    angle, spin = initial_angles(scene), np.zeros(len(state.position))
    spin[len(spin) - len(scene.rows) :] = [row.spin for row in scene.rows]
    return state._replace(turning=np.stack([angle, spin], axis=1))


def _with_headings(active: Array, scene: FloatingScene, turns: bool) -> Array:
    """The state of active floats with the given headings; the headings of floats that turn are along their angles."""
    found, first = active.copy(), len(active) - len(scene.rows)
    for i, row in enumerate(scene.rows, first):
        if row.angle is not None:
            found[i, 2] = 0.0 if turns else row.angle
    return found


def initial_angles(scene: FloatingScene) -> Array:
    """The angles of all floats, given or random."""
    count = sum(one.count for one in scene.particles)
    angles = np.random.default_rng([scene.seed, TURNS]).uniform(0.0, 2.0 * math.pi, count + len(scene.rows))
    turned = [species.shape or species.disc for species in scene.particles]
    given = [math.nan if one is None or one.angle is None else one.angle for one in turned]
    listed = np.repeat(given, [one.count for one in scene.particles])
    listed = np.concatenate([listed, [_angle_of(row) for row in scene.rows]])
    if scene.waves is not None and scene.waves.headings:
        listed = np.array(scene.waves.headings)
    return np.where(np.isnan(listed), angles, listed)


def _angle_of(row: FloatRow) -> float:
    """The angle of a row, by default that of its disc or shape, or 0."""
    figure = row.shape or row.disc
    given = row.angle if row.angle is not None or figure is None else figure.angle
    return 0.0 if given is None else given


def _check(scene: FloatingScene, parameters: Parameters, position: Array, which: Integers) -> None:
    """Raise SceneError for given positions of floats that overlap or are outside the dish."""
    tolerance = SLIGHT if contacts_of(parameters).stores_overlaps else TOUCHING
    faults = position_faults(parameters, position, which, float_names(scene), tolerance)
    if faults:
        more = [Fault("", f"and {len(faults) - MOST_FAULTS} more of these")] if len(faults) > MOST_FAULTS else []
        raise SceneError(faults[:MOST_FAULTS] + more)


def position_faults(
    parameters: Parameters, position: Array, which: Integers, names: list[str], tolerance: float = TOUCHING
) -> list[Fault]:
    """A fault for each of these floats that overlaps another by more than a fraction of its radius, or is outside."""
    outside = _outside(parameters, position, which, names, tolerance)
    return [*outside, *_overlapping(parameters, position, which, names, tolerance)]


def _check_shapes(scene: FloatingScene, parameters: Parameters, position: Array, which: Any) -> None:
    """Raise SceneError for given positions and initial angles of shapes that overlap or are outside the dish."""
    names, radius, faults = float_names(scene), parameters.floats.radius, []
    # Floats at random positions are not placed yet: here they get positions far away.
    far = 4.0 * (np.abs(np.nan_to_num(position)).max() + radius.sum()) * (1.0 + np.arange(len(position)))
    there = np.where(np.isnan(position), far[:, None], position)
    for i, j, gap in gaps_between(parameters, there, initial_angles(scene), 0.0):
        if parameters.passing and j < len(radius):
            continue
        if i in which and (j in which or j >= len(radius)) and -gap > TOUCHING * radius[i]:
            other = f"{names[j]}" if j < len(radius) else "the dish's wall"
            faults.append(Fault(names[i], f"overlaps {other} by {with_prefix(-gap, 'm', 3)}"))
    if faults:
        raise SceneError(faults[:MOST_FAULTS])


def float_names(scene: FloatingScene) -> list[str]:
    """The path of each float in the scene."""
    counts = [species.count for species in scene.particles]
    names = [f"particles[{k}].positions[{n}]" for k, count in enumerate(counts) for n in range(count)]
    return names + [f"rows[{k}]" for k in range(len(scene.rows))]


def _outside(
    parameters: Parameters, position: Array, which: Integers, names: list[str], tolerance: float
) -> list[Fault]:
    faults = []
    for i in which:
        sunk_in = _into_walls(parameters.walls, position[i], parameters.floats.radius[i])
        if sunk_in > tolerance * parameters.floats.radius[i]:
            (x, y), depth = position[i], with_prefix(sunk_in, "m", 3)
            faults.append(
                Fault(names[i], f"({x:g} m, {y:g} m) is not inside the dish: it overlaps the wall by {depth}")
            )
    return faults


def _into_walls(walls: Walls, place: Array, radius: float) -> float:
    return radius - min(rings.clearances(walls, place), default=math.inf)


def _overlapping(
    parameters: Parameters, position: Array, which: Integers, names: list[str], tolerance: float
) -> list[Fault]:
    if len(which) < 2 or parameters.passing:
        return []
    places, radius = np.ascontiguousarray(position[which]), parameters.floats.radius[which]
    periods = parameters.periods
    capacity = 64 * len(which)
    lists, candidates = make_lists(len(which), 2, capacity, periods), contacts.make_candidates(len(which), capacity)
    reach = 2.0 * float(radius.max())
    require_threads(len(which))
    if not (build(lists, places, reach) and list_candidates(candidates, lists, radius, 0.0)):
        return [Fault("particles", f"more than {capacity} pairs of floats overlap")]
    faults = []
    for i in range(len(which)):
        for j in candidates.partner[candidates.first[i] : candidates.first[i + 1]]:
            overlap = radius[i] + radius[j] - math.hypot(*contacts.apart(places, i, j, periods))
            if overlap > tolerance * min(radius[i], radius[j]):
                faults.append(Fault(names[which[i]], f"overlaps {names[which[j]]} by {with_prefix(overlap, 'm', 3)}"))
    return faults
