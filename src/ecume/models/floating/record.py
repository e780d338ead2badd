"""The record of the floating model: the functions that a run calls."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ecume.laws import brownian_motion, capillarity, contact_lines, drag, flotation, immersion, meniscus, pair_laws
from ecume.models.actions import Access
from ecume.models.diagnosis import DEEP, first_broken, when
from ecume.models.floating.check_report import summary
from ecume.models.floating.contacts.contact_models import contacts_of, gaps_between, rows_for
from ecume.models.floating.forces.barrier import with_walls_of
from ecume.models.floating.frames import OVERLAP, invariants, observe
from ecume.models.floating.parameters import (
    DEEPEST,
    WORK,
    Parameters,
    State,
    SurfactantState,
    Workspace,
    compiled_state,
    make_workspace,
)
from ecume.models.floating.setup.initial_state import layout, position_faults, start
from ecume.models.floating.setup.scene_parameters import ROOMIER, checked_parameters, chosen_by
from ecume.models.floating.time_integration.integration import advance, fill_lists, forces_at, make_scratch
from ecume.models.floating.time_integration.integrators import INTEGRATORS_BY_CONSTANTS, thermalize
from ecume.models.floating.user_laws import interaction_of
from ecume.models.model import Model, Source
from ecume.models.user_laws import BoundLaw
from ecume.units import Array, with_prefix

if TYPE_CHECKING:
    from ecume.scenes.floating import FloatingScene


def laws_of(scene: Any) -> list[Source]:
    """The sources of the laws of a scene: equilibrium, attraction, dish, drag and collisions."""
    charge = flotation.CHARGES.get(str(scene.interaction.charge))
    laws: list[Source] = [charge] if charge else []
    row = pair_laws.PAIR_LAWS.get(str(scene.interaction.law))
    laws += row.papers if row is not None else ()
    chosen = chosen_by(scene)
    laws += [law for row in chosen.interactions for law in row.laws]
    if scene.dish is not None:
        laws += capillarity.WALLS.get(str(scene.dish.law), ())
        laws += [meniscus.dish_height, *([meniscus.plane_image_force] if scene.dish.image != "none" else [])]
    laws += [immersion.immersion_factor, drag.stokes_friction] if scene.hydrodynamics.resists else []
    if scene.shaped:
        resistance = [contact_lines.ellipsoid_friction, contact_lines.ellipsoid_turning_friction]
        laws += resistance if scene.hydrodynamics.resists else []
        laws += [contact_lines.spin_in_flow] if scene.flow is not None else []
    laws += [brownian_motion.diffusivity, brownian_motion.reflected_gap] if scene.hydrodynamics.brownian else []
    laws += [thermalize] if scene.hydrodynamics.brownian and chosen.integrator.scheme.inertia else []
    return [*laws, *chosen.hydrodynamics.laws, *chosen.contacts.laws]


def workspace(parameters: Parameters, state: State, room: float) -> Workspace:
    """Allocate the workspace, with neighbor lists at the reference positions of the state."""
    while True:
        velocities = INTEGRATORS_BY_CONSTANTS[type(parameters.parts.integrator)].velocities
        made = make_workspace(parameters, state, room, velocities)
        made = made._replace(contacts=rows_for(parameters, made.contacts))
        made = made._replace(scratch=make_scratch(parameters, state, made))
        bare, space = parameters._replace(parts=()), made._replace(scratch=())
        if fill_lists(parameters.parts, made.scratch, bare, compiled_state(state), space):
            return made
        room *= ROOMIER


def diagnosis(parameters: Parameters, state: State) -> str:
    """The message on the float that diverged, with the time and the remedy."""
    what, far = _who_and_what(parameters, state)
    steps = math.ceil(parameters.steps_per_frame * min(max(SHORTER, far / parameters.skin), LONGEST))
    shorter = parameters.time_step * parameters.steps_per_frame / steps
    return (
        f"{when(parameters, state)} {what}: too far for one time step of {parameters.time_step:.3g} s. Set "
        f"integration.time_step = {shorter:.9g}, or look for overlapping floats"
    )


SHORTER, LONGEST = 4.0, 1e3
"""The smallest and the largest factor by which a diverged time step should be reduced."""


def _who_and_what(parameters: Parameters, state: State) -> tuple[str, float]:
    """The cause of a failure: the float with a position or velocity that is not finite, the pair moved apart by
    contacts, or the fastest float; and its displacement in a step (m).
    """
    broken = first_broken({"position": state.position, "velocity": state.velocity})
    if broken is not None:
        return f"float {broken.particle} has a {broken.term} that is not finite", 0.0
    if state.tally[DEEPEST] > DEEP * parameters.floats.radius.min():
        # Contacts have moved them apart by more than the largest displacement in a step.
        one, other = np.argsort(-np.linalg.norm(state.position - state.reference, axis=1))[:2]
        depth = with_prefix(state.tally[DEEPEST], "m", 3)
        return f"floats {one} and {other} were separated from an overlap of {depth}", 0.0
    speed = _speeds(parameters, state)
    fastest = int(np.argmax(speed))
    x, y = (with_prefix(place, "m") for place in state.position[fastest])
    found = f"float {fastest} moves at {with_prefix(speed[fastest], 'm/s', 3)} (at {x}, {y})"
    return found, parameters.time_step * float(speed[fastest]) + parameters.drift.jump


def _speeds(parameters: Parameters, state: State) -> Array:
    """The highest speed of each float in the next step (m/s): its present speed, except where drag stops it within a
    kick, plus the speed gained in a kick.
    """
    here = state._replace(reference=state.position.copy(), step=state.step.copy(), skin=np.zeros(1))
    force, kick = forces_at(parameters, state.position, workspace(parameters, here, 1.0)), parameters.kick
    with np.errstate(over="ignore"):
        own = np.where(kick.decay > 0.0, np.hypot(state.velocity[:, 0], state.velocity[:, 1]), 0.0)
        return np.asarray(own + kick.gain * np.hypot(force[:, 0], force[:, 1]))


def faults(scene: FloatingScene, parameters: Parameters, state: State) -> list[str]:
    """Messages on floats that overlap by more than contacts tolerate, or are outside the dish."""
    parameters = with_walls_of(parameters, state)
    radius = parameters.floats.radius
    names = [f"float {i}" for i in range(len(radius))]
    if contacts_of(parameters).gaps is not None:
        gaps = gaps_between(parameters, state.position, state.turning[:, 0], 0.0)
        walls = "the wall of the dish"
        return [
            f"{names[i]} overlaps {names[j] if j < len(radius) else walls} by {-gap:.3g} m"
            for i, j, gap in gaps
            if -gap > OVERLAP * radius[i] and (j >= len(radius) or not parameters.passing)
        ]
    which = np.arange(len(radius))
    return [f"{path} {what}" for path, what, *_ in position_faults(parameters, state.position, which, names, OVERLAP)]


def changed(state: State, moved: bool) -> None:
    """Mark neighbor lists and stored contacts as invalid after positions were changed."""
    if moved:
        state.reference[:] = state.position
        state.touches[0] = 0


FLOATS = Access(
    arrays=lambda state: {"position": state.position, "velocity": state.velocity},
    faults=faults,
    changed=changed,
    work=lambda state: state.tally[WORK : WORK + 1],
    sides=lambda parameters: parameters.periods[0],
)


def extended(laws: Sequence[BoundLaw]) -> Model:
    """The floating model with pair laws of the user."""
    further = (interaction_of(laws),)
    return dataclasses.replace(
        FLOATING,
        parameters=lambda scene: checked_parameters(scene, further),
        summary=lambda scene: summary(scene, further),
    )


FLOATING = Model(
    name="floating",
    state=State,
    further_state=lambda scene: None if scene.surfactant is None else SurfactantState,
    parameters=checked_parameters,
    start=start,
    layout=layout,
    workspace=workspace,
    advance=advance,
    observe=observe,
    constant=frozenset(["radius", "mass", "charge", "density", "contact_angle", "species", "magnetic_moment"]),
    main_numbers=("kinetic_energy", "total_energy", "largest_speed", "clusters", "contacts"),
    diagnosis=diagnosis,
    extended=extended,
    access=FLOATS,
    invariants=invariants,
    laws=laws_of,
    summary=summary,
)
