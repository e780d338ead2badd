"""The table of hydrodynamic interactions between floats."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.laws import ewald, pair_mobility
from ecume.laws.pair_mobility import MOST_SOLVED, raft_speed_factor
from ecume.models.floating.contacts.contact_models import CONTACTS, ContactModel
from ecume.models.floating.coupled.many_floats import ERROR, MATRIX_UP_TO
from ecume.models.floating.coupled.mobility import CoupledKicks, GridKicks, hydrodynamic_radius
from ecume.models.floating.forces.interactions import RESISTANCES, Resistance
from ecume.models.floating.forces.pair_forces import law_of, row_of, two_floats
from ecume.models.floating.options import Option
from ecume.models.floating.parameters import Parameters, distinct_rows
from ecume.models.floating.setup.kinds import turning_frictions
from ecume.models.floating.time_integration.integrators import COUPLED, COUPLED_ON_GRID, Integrator
from ecume.models.liquids import float_reynolds, is_under_liquid, liquid_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene

RAFT_MOBILITY = 1.7
"""Speed of a compact raft over that of a single float, over the square root of the number of floats: that of a flat
disc of the same area, 9 pi/16 sqrt(0.9069), which smaller rafts do not reach.
"""


class ReynoldsWarning(UserWarning):
    """Floats move too fast for the flow that the mobility assumes."""


def missing_in_rafts(count: int) -> tuple[str, str]:
    """The row on rafts without hydrodynamic interaction: the factor by which they are too slow, since each float has
    the drag of a single one.
    """
    largest = min(count, MOST_SOLVED)
    value = f"up to {raft_speed_factor(largest):.2g} times too slow"
    return value, f"compact rafts of {largest} in creeping flow: hydrodynamic interaction is not included"


def included_in_rafts(count: int) -> tuple[str, str]:
    """The row on rafts with hydrodynamic interaction: the factor by which they are faster than single floats."""
    largest = min(count, MOST_SOLVED)
    value = f"up to {raft_speed_factor(largest):.2g} times a single float"
    return value, f"compact rafts of {largest}, by their flow; the flow at the walls of a dish is not included"


def summed_in_rafts(count: int) -> tuple[str, str]:
    """The row on rafts with hydrodynamic interaction on a grid, with its accuracy."""
    value, remark = included_in_rafts(count)
    return value, f"{remark}; summed on a grid, velocities within {ERROR:g}"


@dataclass(frozen=True, kw_only=True)
class HydrodynamicInteraction(Option):
    """A row of the table, and everything that depends on it, including the rows of other tables that it replaces."""

    slot: str = "hydrodynamic interaction"
    path: str = "hydrodynamics.interaction"
    moves: Callable[[Integrator], Integrator] = lambda integrator: integrator
    """moves(chosen integrator): the integrator whose functions move the floats"""
    make: Callable[[Parameters, FloatingScene, bool], Any] = lambda parameters, scene, turning: ()
    """make(parameters, scene, turning): the constants of that integrator; `turning` if floats have spins"""
    contacts: Mapping[str, str] = field(default_factory=dict)
    """rows of contacts by those that they replace"""
    resistances: Mapping[str, str] = field(default_factory=dict)
    """rows of resistances by those that they replace"""
    raft_mobility: Callable[[int], float] = lambda count: 1.0
    """collective(number of floats): see `Parameters.raft_mobility`"""
    raft_speeds: Callable[[int], tuple[str, str]] = missing_in_rafts
    """raft_speeds(number of floats): the value and the remark of `ecume check` on the drift of rafts"""
    most_reynolds: float = math.inf
    """the Reynolds number of two touching floats above which a run warns"""
    laws: tuple[Callable[..., Any], ...] = ()
    """functions whose docstrings name the references that `ecume cite` lists"""

    def contact_model(self, name: str) -> ContactModel:
        """The row of the contact model for a choice."""
        return CONTACTS[self.contacts.get(name, name)]

    def resistance(self, name: str) -> Resistance:
        """The row of the resistances for a choice."""
        return RESISTANCES[self.resistances.get(name, name)]


def coupled_kicks_of(parameters: Parameters, scene: FloatingScene, turning: bool) -> CoupledKicks:
    """Return the constants of floats that interact through the liquid."""
    viscosity = liquid_of(scene).viscosity_of_both
    radius = hydrodynamic_radius(parameters, viscosity)
    spin = _further_spin(scene, radius, viscosity) if turning else np.zeros(0)
    return CoupledKicks(radius, spin, viscosity, parameters.drift.thermal)


def _further_spin(scene: FloatingScene, radius: Array, viscosity: float) -> Array:
    """The rotational mobility of each single float minus that of the half-immersed sphere with the same drag; at least
    zero, since the matrix must remain positive definite.
    """
    return np.asarray(np.maximum(1.0 / turning_frictions(scene) - 1.0 / (4.0 * math.pi * viscosity * radius**3), 0.0))


HYDRODYNAMICS = {
    "none": HydrodynamicInteraction(name="'none'", gives=frozenset({"single drag", "lone"})),
    "rotne-prager": HydrodynamicInteraction(
        name="'rotne-prager'", moves=lambda integrator: COUPLED, make=coupled_kicks_of,
        contacts={"none": "coupled", "impulse": "coupled", "friction": "coupled friction"},
        resistances={"films": "coupled films"},
        raft_mobility=lambda count: RAFT_MOBILITY * math.sqrt(count), raft_speeds=included_in_rafts, most_reynolds=1.0,
        laws=(pair_mobility.pair_mobility,),
        needs={
            "no inertia": "the mobility is that of creeping flow, which follows the forces at once",
            "drag": "the flow that moves other floats comes from the drag on each",
            "round": "the mobilities of spheres are known in closed form",
            "open": "the flow of a float decays as 1/r only, so that images at all distances move it",
            "full mobility": "the force of a contact moves all floats, and must stop those in contact",
        },
    ),
}  # fmt: skip
"""The hydrodynamic interactions by the names of `hydrodynamics.interaction`."""


MANY = replace(
    HYDRODYNAMICS["rotne-prager"], moves=lambda integrator: COUPLED_ON_GRID,
    make=lambda parameters, scene, turning: GridKicks(*coupled_kicks_of(parameters, scene, turning)),
    raft_speeds=summed_in_rafts,
    laws=(pair_mobility.pair_mobility, ewald.smooth_flow),
)  # fmt: skip
"""Replaces the matrix of Rotne and Prager's mobilities for many floats."""


def hydrodynamics_of(scene: FloatingScene) -> HydrodynamicInteraction:
    """The hydrodynamic interaction of a scene, as a row of the table. Many floats use a grid instead of a matrix,
    except with friction or films.
    """
    row = HYDRODYNAMICS[scene.hydrodynamics.interaction]
    count = len(scene.rows) + sum(species.count for species in scene.particles)
    simple = scene.hydrodynamics.lubrication is None and not scene.rubs
    many = row is HYDRODYNAMICS["rotne-prager"] and count > MATRIX_UP_TO and simple
    return MANY if many else row


def touching_reynolds(parameters: Parameters, scene: FloatingScene) -> float:
    """The Reynolds number of the approach of the two equal floats with the strongest attraction, with the drag of
    single floats.
    """
    row, law, floats, liquid = row_of(parameters), law_of(parameters), parameters.floats, liquid_of(scene)
    friction, highest = floats.mass / floats.relaxation_time, 0.0
    kinds = distinct_rows(floats.radius, np.abs(floats.charge), friction).tolist()
    for radius, charge, drag in kinds if row.has_force else []:
        pull = abs(float(row.force(2.0 * radius, two_floats(parameters, (radius, radius), (charge, charge)), law)))
        highest = max(highest, float_reynolds(pull / drag, radius, liquid))
    return highest


class GasWarning(UserWarning):
    """The gas above the liquid has the density of a liquid, but no viscosity is given."""


def warn_of_dense_gas(scene: FloatingScene) -> None:
    """Warn if the gas above the liquid is so dense that it is a liquid, and its viscosity is missing."""
    liquid = liquid_of(scene)
    if not (scene.hydrodynamics.resists and is_under_liquid(liquid)) or liquid.gas_viscosity > 0.0:
        return
    message = (
        f"liquid.gas_density: got {liquid.gas_density:g} kg/m^3, the density of a liquid, but drag is that of the "
        "lower liquid alone. A liquid of the same viscosity above it doubles the drag of half-immersed floats, "
        "and halves their speeds and diffusion; in general the factor is 1 + eta_above/eta. Expected the viscosity of "
        "the upper liquid in liquid.gas_viscosity"
    )
    warnings.warn(message, GasWarning, stacklevel=2)


def warn_of_fast_floats(row: HydrodynamicInteraction, parameters: Parameters, scene: FloatingScene) -> None:
    """Warn if the flow is not creeping."""
    if row.most_reynolds == math.inf:
        return
    found = touching_reynolds(parameters, scene)
    if found > row.most_reynolds:
        message = (
            f"{row.path}: two floats meet at a Reynolds number of {found:.2g}; {row.name} is the mobility of creeping "
            f"flow, below {row.most_reynolds:g}. Expected smaller floats or a more viscous liquid"
        )
        warnings.warn(message, ReynoldsWarning, stacklevel=2)
