"""The periodic cell of a scene, and the smallest one in which nearest images are enough.

Each float interacts with the nearest image of every other float. That is the sum over all images if no force reaches
farther than half of the shorter side. Beyond the cutoff the attraction decays as K1, exponentially: a cell that is
twice as wide as the cutoff omits no more than `interaction.accuracy` allows.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from ecume.engine.periodic import no_periods, periods_of
from ecume.laws import capillarity
from ecume.models.floating.forces.pair_forces import row_of
from ecume.models.floating.options import Built, Option, scene_error
from ecume.models.floating.parameters import CAPILLARY_LENGTH, Parameters
from ecume.units import Array
from ecume.value_texts import with_prefix

if TYPE_CHECKING:
    from collections.abc import Iterable

    from ecume.scenes.floating import FloatingScene

CELL = Option(slot="boundary", path="cell", name="a periodic cell")
OPEN = Option(slot="boundary", path="dish", name="a dish or an infinite surface", gives=frozenset({"open"}))
GRADIENT = Option(
    slot="flow gradient", path="flow", name="a flow with a gradient",
    needs={"open": "its velocity differs on opposite borders of a cell"},
)  # fmt: skip


def boundary_of(scene: FloatingScene) -> list[Option]:
    """The boundary of a scene, and a flow that is not uniform, as options."""
    flow = scene.flow
    gradient = flow is not None and bool(
        flow.shear_rate or flow.rotation_rate or flow.extension_rate or flow.nodes is not None
    )
    return [OPEN if scene.cell is None else CELL, *([GRADIENT] if gradient else [])]


def periods_in(scene: FloatingScene) -> Array:
    """The periods of the scene's cell; zero without a cell."""
    return no_periods(2) if scene.cell is None else periods_of(scene.sides)


class Range(NamedTuple):
    """How far a force of the scene reaches (m), and what shortens it."""

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


def _contact_range(parameters: Parameters) -> Range:
    return Range("a contact of the largest floats", 2.0 * float(parameters.floats.radius.max()), "")


def _pair_range(parameters: Parameters, half: float) -> list[Range]:
    """The range of the pair law; the hint says which part of the attraction a cutoff at half a side would omit."""
    if not row_of(parameters).has_force:
        return []
    length, contact = float(parameters.pair[CAPILLARY_LENGTH]), 2.0 * float(parameters.floats.radius.max())
    omitted = capillarity.neglected_fraction(half / length, contact / length)
    if not 0.0 < omitted < 1.0:  # zero in cells far wider than any force reaches
        return [Range("the attraction", parameters.cutoff, "")]
    hint = (
        f" (interaction.accuracy = {_rounded_up(omitted, 2):g} would accept this cell: that fraction of the attraction "
        "at a raft's edge would be omitted)"
    )
    return [Range("the attraction", parameters.cutoff, hint)]


def _part_range(row: Any, built: Built, parameters: Parameters, half: float) -> Range:
    """The range of a further force: of magnets, it follows from the accuracy; of films, from their own cutoff."""
    if row.path == "hydrodynamics.lubrication":
        return Range("a film", built.reach, " (a smaller hydrodynamics.lubrication.cutoff shortens the films)")
    touching = 2.0 * float(parameters.floats.radius.min())
    accuracy = _rounded_up((touching / half) ** 2, 2)
    return Range(row.name, built.reach, f" (interaction.accuracy = {accuracy:g} would accept this cell)")


def _rounded_up(value: float, digits: int) -> float:
    unit = 10.0 ** (math.floor(math.log10(value)) + 1 - digits)
    return float(f"{math.ceil(value / unit * (1.0 - 1e-12)) * unit:.{digits}g}")
