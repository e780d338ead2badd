"""User laws for liquids: forces between pairs of particles, and external accelerations.

Pair laws act between particles of the liquid, also across periodic sides, up to the support of the kernel; they do not
act on walls and bodies. The accelerations by user laws are added to the others, so that they limit the time step as
well. Their power is injected work.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ecume.engine.cells import Integers
from ecume.engine.neighbor_rows import Lists
from ecume.models.invariants import Invariant
from ecume.models.model import Model
from ecume.models.sph.boundaries.forces_on_solids import chains_of, roots_of
from ecume.models.sph.fields import Floats
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.state import State, Workspace
from ecume.models.user_laws import (
    EXTERNAL,
    PAIR,
    BoundLaw,
    compiled_for_laws,
    flags_of,
    masks_of,
    require_acceleration,
    require_force,
    require_kinds,
    row_as_tuple,
    sum_of_external_laws,
    sum_of_pair_laws,
)
from ecume.scenes.sph import SphScene
from ecume.units import Array


class LiquidPair(NamedTuple):
    """The properties of two liquid particles that user laws receive, in addition to their distance."""

    mass_i: float
    mass_j: float
    density_i: float
    density_j: float
    spacing: float
    constants: tuple[float, ...]


class LiquidParticle(NamedTuple):
    """The properties of a liquid particle that external user laws receive, in addition to position, velocity and
    time.
    """

    mass: float
    density: float
    constants: tuple[float, ...]


class Two(NamedTuple):
    """A pair without the constants of a law."""

    mass_i: float
    mass_j: float
    density_i: float
    density_j: float
    spacing: float


class One(NamedTuple):
    """A particle without the constants of a law."""

    mass: float
    density: float


@compiled_for_laws
def joined_pair(own: Two, constants: Any) -> LiquidPair:
    """The parameters of a pair law."""
    return LiquidPair(own.mass_i, own.mass_j, own.density_i, own.density_j, own.spacing, constants)


@compiled_for_laws
def joined_particle(own: One, constants: Any) -> LiquidParticle:
    """The properties of a particle together with the constants of a law."""
    return LiquidParticle(own.mass, own.density, constants)


@dataclass(frozen=True)
class UserForces:
    """The compiled laws of a scene."""

    mask: NDArray[np.int64]
    """(S, S) the pair laws of each pair of regions, as bits"""
    flags: NDArray[np.int64]
    """(S,) the external laws of each region, as bits"""
    pair_loop: Callable[..., None] | None
    external_loop: Callable[..., None] | None

    def __call__(self, parameters: Parameters, state: State, workspace: Workspace) -> Array:
        """The acceleration of each particle of the liquid (m/s^2), (d, N)."""
        found = np.zeros_like(state.position)
        if self.pair_loop is not None:
            root = _root_in_liquid(parameters, state, workspace)
            self.pair_loop(
                workspace.fields.position, workspace.lists, root, (state.region, self.mask),
                (state.mass, state.density), (parameters.spacing, parameters.support), found,
            )  # fmt: skip
        if self.external_loop is not None:
            particles = state.position.T.copy(), state.velocity.T.copy(), state.mass, state.density
            added = np.zeros_like(particles[0])
            self.external_loop(*particles, self.flags[state.region], float(state.clock[0]), added)
            found += added.T
        return found


def _root_in_liquid(parameters: Parameters, state: State, workspace: Workspace) -> Integers:
    """The index of the liquid particle for each column that is a liquid particle or its periodic image; -1 for all
    others.
    """
    images, real = workspace.images, len(workspace.lists.counts)
    root = np.concatenate([np.arange(real), roots_of(images, real)])
    mirrors = sum(1 << int(side) for side in np.flatnonzero(parameters.boundary.image_owner >= 0))
    chain = np.concatenate([np.zeros(real, np.int64), chains_of(images, real)])
    return np.where((root < len(state.mass)) & (chain & mirrors == 0), root, -1)


def extended(model: Model, laws: Sequence[BoundLaw]) -> Model:
    """The model with user laws. Raises BadInput for functions that are not such laws."""
    require_kinds("sph", laws, [PAIR, EXTERNAL])
    pairs, external = ([law for law in laws if law.arguments == kind] for kind in (PAIR, EXTERNAL))
    for law in pairs:
        one, other = (LiquidPair(*masses, 1000.0, 900.0, 1e-2, law.constants) for masses in ((0.1, 0.2), (0.2, 0.1)))
        require_force(law, (3e-3, 1e-2, 2e-2), one, other._replace(density_i=900.0, density_j=1000.0))

    def parameters_of(scene: SphScene) -> Parameters:
        parameters: Parameters = model.parameters(scene)
        for law in external:
            particle = LiquidParticle(0.1, 1000.0, law.constants)
            require_acceleration(law, (1e-3,) * parameters.dimension, particle)
        regions = max(len(scene.fluid), 1)
        forces = UserForces(
            masks_of(pairs, regions),
            flags_of(external, regions),
            _pair_loop(sum_of_pair_laws(pairs, joined_pair)) if pairs else None,
            _external_loop(external, parameters.dimension) if external else None,
        )
        return parameters._replace(user_forces=forces)

    def invariants(scene: SphScene, parameters: Parameters) -> list[Invariant]:
        rows = model.invariants(scene, parameters)
        return [row for row in rows if not (external and row.name == "momentum")]

    return dataclasses.replace(model, parameters=parameters_of, invariants=invariants)


def _pair_loop(total: Callable[..., float]) -> Callable[..., None]:
    """Return the loop over all neighbors of each particle."""

    @compiled_for_laws
    def loop(
        position: Floats,
        lists: Lists,
        root: Integers,
        regions: tuple[Integers, Integers],
        liquid: tuple[Array, Array],
        lengths: tuple[float, float],
        out: Array,
    ) -> None:
        region, masks = regions
        mass, density = liquid
        spacing, support = lengths
        for i in range(out.shape[1]):
            for place in range(lists.counts[i]):
                column = lists.neighbor[lists.start[i] + place]
                j = root[column]
                if j < 0 or column == i:
                    continue
                mask = masks[region[i], region[j]]
                square = 0.0
                for axis in range(out.shape[0]):
                    square += (position[axis, column] - position[axis, i]) ** 2
                distance = math.sqrt(square)
                if mask and 0.0 < distance < support:
                    own = Two(mass[i], mass[j], density[i], density[j], spacing)
                    over = total(distance, own, mask) / (distance * mass[i])
                    for axis in range(out.shape[0]):
                        out[axis, i] -= over * (position[axis, column] - position[axis, i])

    return loop


def _external_loop(laws: Sequence[BoundLaw], dimension: int) -> Callable[..., None]:
    """Return the loop over particles."""
    total, row = sum_of_external_laws(laws, joined_particle), row_as_tuple(dimension)

    @compiled_for_laws
    def loop(
        position: Array, velocity: Array, mass: Array, density: Array, flags: Integers, time: float, out: Array
    ) -> None:
        for i in range(len(position)):
            own = One(mass[i], density[i])
            total(row(position, i), row(velocity, i), time, own, flags[i], out[i])

    return loop
