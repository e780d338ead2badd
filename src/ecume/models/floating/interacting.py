"""How floats interact: by superposed pair forces, by corrected ones, or all at once; each with a march of its own."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ecume.engine.cells import Integers
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws import drag, flotation
from ecume.laws.dipoles import dipole_force, dipole_strength
from ecume.laws.multipole import Undulated
from ecume.models.floating import corrected, films, grid, many, polar, stepping
from ecume.models.floating.pair_choice import require, summed_law
from ecume.models.floating.parameters import (
    OVERDAMPED,
    RARE,
    SEMI_IMPLICIT_EULER,
    Parameters,
)
from ecume.models.floating.shaped.bodies import Shaped, make_crew
from ecume.models.floating.state import State, Workspace
from ecume.models.floating.summing import Split
from ecume.models.floating.walls.menisci import acts, has_far_field
from ecume.models.floating.walls.shapes import meniscus_of
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import FloatingScene
from ecume.units import Array

Bodies = list[tuple[Any, float]]
RAFT_NEIGHBORS = 6.0


def with_multipoles(parameters: Parameters, scene: FloatingScene, kinds: Sequence[Any], number: Integers) -> Parameters:
    """All floats on one surface. Raises SceneError for walls that go by another law."""
    dish = scene.dish
    if not has_far_field(parameters) or (dish is not None and dish.law == "linear"):
        raise _fault("dish.law", "multipoles go with a dish's 'meniscus' or 'none', without another wall law")
    bodies, liquid = bodies_of(kinds), liquid_of(scene)
    found = _made(
        lambda: many.make_many([bodies[k] for k in number], liquid, scene.interaction.order, parameters.cutoff)
    )
    if dish is not None and acts(parameters):
        found = meniscus_of(dish).multipoles(found, dish, liquid)
    parameters = parameters._replace(many=found, stiffer=_stiffer(bodies))
    undulated = any(kind.rim[1] > 0.0 for kind in kinds)
    return with_turning(parameters, scene, [kinds[k] for k in number]) if undulated else parameters


def with_turning(parameters: Parameters, scene: FloatingScene, every: Sequence[Any]) -> Parameters:
    """Floats that turn: their inertia, m a^2/2, what resists, and how quick the stiffest of them is.

    A rim of height H feels a neighbor that touches as a spring of about 12 pi gamma (m H/4)^2 when it turns, over a^2
    when it shifts, by the law of quadrupoles at l = 2 a; six of them at most.
    """
    if parameters.scheme in (*RARE, OVERDAMPED):
        raise _fault("motion.integrator", "floats that turn go by 'velocity-verlet' or one of the Euler schemes")
    liquid = liquid_of(scene)
    mass, radius = parameters.floats.mass, parameters.floats.radius
    resisting = [drag.disc_turning_friction(float(a), liquid.viscosity) if scene.motion.drag else 0.0 for a in radius]
    moment, friction = 0.5 * mass * radius**2, np.array(resisting)
    height = max(kind.rim[0] * kind.rim[1] for kind in every)
    spring = RAFT_NEIGHBORS * 12.0 * math.pi * liquid.surface_tension * (0.5 * height) ** 2
    turning = np.maximum(np.sqrt(moment / spring), friction / spring)
    shifting = np.sqrt(mass / spring) * radius
    quickest = float(min(turning.min(), shifting.min()))
    many_floats = parameters.many._replace(inertia=moment, friction=friction)
    return parameters._replace(many=many_floats, quickest=quickest)


def with_corrections(
    parameters: Parameters, scene: FloatingScene, kinds: Sequence[Any], number: Integers
) -> Parameters:
    """Pair forces with tables. Raises SceneError where there are too many kinds of floats."""
    if len(kinds) > corrected.MOST_KINDS:
        raise _fault(
            "interaction.method",
            f"'pair-corrected' needs a table for each pair of kinds, and there are {len(kinds)} of them, more than "
            f"{corrected.MOST_KINDS}; take 'multipole' or 'superposition'",
        )
    bodies = bodies_of(kinds)
    tables = _made(lambda: corrected.make_corrected(bodies, number, liquid_of(scene), parameters.cutoff))
    return parameters._replace(many=tables, stiffer=_stiffer(bodies))


def with_dipoles(parameters: Parameters, scene: FloatingScene, moment: Array) -> Parameters:
    """Floats that are magnets. Raises SceneError where they go by another method.

    Two that touch are a spring of 4 F/l; six of them at most.
    """
    if scene.interaction.method != "superposition":
        raise _fault("interaction.method", "magnets go with 'superposition'")
    require(parameters, "interaction.law", "a magnet", "reciprocal")
    if scene.rubs:
        raise _fault("contacts.friction", "magnets go without friction")
    radius, walls = parameters.floats.radius, parameters.walls
    touching = 2.0 * float(radius.min())
    across = 2.0 * min(walls.disc_radius, float(np.hypot.reduce(walls.offset)) if len(walls.offset) else math.inf)
    cutoff = min(touching / math.sqrt(scene.interaction.accuracy), across)
    strongest = float(np.abs(moment).max())
    at_contact = dipole_force(touching, dipole_strength(strongest, strongest))
    spring, floats = 2.0 * RAFT_NEIGHBORS * 4.0 * at_contact / touching, parameters.floats
    quickest = float(np.min(np.sqrt(floats.mass / spring)))
    if parameters.scheme == OVERDAMPED:
        quickest = float(np.min(floats.mass / floats.relaxation_time)) / spring
    return parameters._replace(
        many=polar.make_polar(moment, cutoff),
        quickest=min(parameters.quickest, quickest),
        reach=max(parameters.reach, cutoff + parameters.skin),
    )


def with_films(parameters: Parameters, scene: FloatingScene) -> Parameters:
    """Films between floats. Raises SceneError where they go by another method, or have no drag."""
    asked, motion = scene.motion.films, scene.motion
    assert asked is not None  # noqa: S101  # for the type checker: the caller has looked
    if scene.interaction.method != "superposition":
        raise _fault("motion.films", "films go with interaction.method = 'superposition', and not with dipoles")
    require(parameters, "motion.films", "a film", "reciprocal")
    if parameters.scheme not in (OVERDAMPED, SEMI_IMPLICIT_EULER) or motion.drag_law != "stokes":
        raise _fault(
            "motion.films", "films want motion.integrator = 'overdamped' or 'semi-implicit-euler', and Stokes's drag"
        )
    if scene.rubs:
        raise _fault("motion.films", "films go without friction")
    if not motion.drag or scene.liquid.viscosity == 0.0 or motion.temperature > 0.0:
        raise _fault("motion.films", "films want drag and a viscosity, and no temperature")
    largest, smallest = float(parameters.floats.radius.max()), float(parameters.floats.radius.min())
    return parameters._replace(
        many=films.make_films(asked.roughness / smallest, asked.reach),
        reach=max(parameters.reach, asked.reach * largest + parameters.skin),
    )


METHODS: dict[str, Callable[[Parameters, FloatingScene, Sequence[Any], Integers], Parameters]] = {
    "multipole": with_multipoles,
    "pair-corrected": with_corrections,
}


def bodies_of(kinds: Sequence[Any]) -> Bodies:
    """Bodies and charges."""
    return [
        (Undulated(kind.body, ((*kind.rim, 0.0),)) if kind.rim[1] > 0.0 else kind.body, kind.charge) for kind in kinds
    ]


def _made(make: Callable[[], Any]) -> Any:
    try:
        return make()
    except BadInput as error:
        raise _fault("interaction.method", str(error)) from None


def _stiffer(bodies: Bodies) -> float:
    discs = [body.disc if isinstance(body, Undulated) else body for body, _ in bodies]
    pinned = any(isinstance(disc, flotation.Disc) and disc.tilting for disc in discs)
    return many.STIFFER if pinned else 2.0


def orders_of(parameters: Parameters) -> int:
    """How many multipoles a float has in the state."""
    return parameters.many.rims.response.shape[1] if isinstance(parameters.many, many.Many) else 0


def turns(parameters: Parameters) -> bool:
    """Whether floats turn."""
    return parameters.rough != () or turned_by_rims(parameters)


def turned_by_rims(parameters: Parameters) -> bool:
    """Whether menisci turn them, or their shapes."""
    return isinstance(parameters.many, (many.Many, Shaped)) and len(parameters.many.inertia) > 0


def inertia_of(parameters: Parameters) -> Array:
    """The moments of inertia of floats that turn (kg m^2), (N,)."""
    return np.asarray(parameters.many.inertia if parameters.rough == () else parameters.rough.inertia)


def scratch_for(parameters: Parameters, state: State, plain: Any, room: int) -> Any:
    """What forces need beside neighbor lists; with room for that many contacts."""
    if isinstance(parameters.many, Shaped):
        return make_crew(parameters, state, room)
    if isinstance(parameters.many, many.Many):
        return many.make_crowd(parameters, state.amplitudes, state.turning)
    if isinstance(parameters.many, polar.Polar):
        return polar.make_magnets(plain, parameters.many)
    return plain


def advance(parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """See `ecume.models.model.Model.advance`."""
    return advance_by(summed_law(parameters), parameters, state, workspace, steps)


def sums_pairs(parameters: Parameters) -> bool:
    """Whether the forces include the sum of the pair law over pairs of floats."""
    return not isinstance(parameters.many, (many.Many, Split, Shaped))


def advance_by(law: Any, parameters: Parameters, state: State, workspace: Workspace, steps: int) -> int:
    """Advance with the pair law that has these constants."""
    if isinstance(parameters.many, Shaped):
        from ecume.models.floating.shaped.marching import march_shaped

        return march_shaped(parameters, state, workspace, steps)
    rare = parameters.scheme in RARE
    if parameters.springs != ():
        from ecume.models.floating.springs import march_springs

        return march_springs(law, parameters, state, workspace, steps)
    if parameters.rough != ():
        from ecume.models.floating import rough_marches

        return rough_marches.advance(law, parameters, state, workspace, steps)
    if turned_by_rims(parameters):
        return many.march_turning(law, parameters, state, workspace, steps)
    if isinstance(parameters.many, many.Many):
        return (many.march_many_rarely if rare else many.march_many)(law, parameters, state, workspace, steps)
    if isinstance(parameters.many, Split):
        return grid.march_split(parameters, state, workspace, steps)
    if isinstance(parameters.many, polar.Polar):
        return (polar.march_polar_rarely if rare else polar.march_polar)(law, parameters, state, workspace, steps)
    if isinstance(parameters.many, films.Films):
        return films.march_slowed(law, parameters, state, workspace, steps)
    if isinstance(parameters.many, corrected.Corrected):
        march = corrected.march_corrected_rarely if rare else corrected.march_corrected
        return march(law, parameters, state, workspace, steps)
    return stepping.advance(law, parameters, state, workspace, steps)


def interaction_energies(parameters: Parameters, state: State, workspace: Workspace) -> tuple[float, float]:
    """Beyond superposed pairs and walls of spheres (J), pairs and walls; multipoles know no difference of the two."""
    if parameters.springs != ():
        from ecume.models.floating.springs import sums_of_spring_energies

        among, at_walls = sums_of_spring_energies(parameters, state, workspace)
        return float(among), float(at_walls)
    if isinstance(parameters.many, Shaped):
        from ecume.models.floating.shaped.forces import shaped_energies

        return shaped_energies(parameters, state, workspace)
    if isinstance(parameters.many, many.Many):
        return many.many_energy(parameters, state), 0.0
    if isinstance(parameters.many, Split):
        return grid.split_energy(parameters, state, workspace), 0.0
    if isinstance(parameters.many, polar.Polar):
        rows = workspace.lists.rows
        listed = rows.first, rows.neighbor, workspace.lists.cells.order
        return float(polar.sum_of_dipole_energies(state.position, parameters.many, listed)), 0.0
    if isinstance(parameters.many, corrected.Corrected):
        return corrected.corrected_energy(parameters, state, workspace), 0.0
    return 0.0, 0.0


def _fault(path: str, message: str) -> SceneError:
    return SceneError([Fault(path, message)])
