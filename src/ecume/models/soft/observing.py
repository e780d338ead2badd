"""A state as a frame: what is where, and how the contacts stand."""

from __future__ import annotations

import numpy as np

from ecume.engine.cells import Integers
from ecume.models.soft.films import stored_energy
from ecume.models.soft.meeting import wraps
from ecume.models.soft.parameters import Drive, Parameters, drive_at
from ecume.models.soft.stages import Step, first_stage
from ecume.models.soft.state import ACCEPTED, CLOCK, FAILED, REJECTED, State, Workspace
from ecume.trajectories.frame import Frame
from ecume.units import Array

SLOTS = {2: 8, 3: 16}
"""Contacts that a sphere tells of in a frame, in each dimension: those with later spheres, narrow gaps first."""
STRESS = {2: "N/m", 3: "Pa"}
"""The unit of stress: in a layer, force over length."""
UNITS = {
    "position": "m",
    "velocity": "m/s",
    "radius": "m",
    "gap": "m",
    "tension": "N",
    "shear": "N",
    "elastic_energy": "J",
    "smallest_gap": "m",
    "largest_tension": "N",
    "largest_compression": "N",
}


def observe(parameters: Parameters, state: State, scratch: Workspace) -> Frame:
    """The frame of this instant."""
    drive = drive_at(parameters.protocol, float(state.pace[CLOCK]))
    step = scratch.step
    first_stage(parameters.contacts, step, drive)
    tension = (step.answers.force * step.direction).sum(axis=1)
    arrays = {
        "position": at_home(parameters, state.position, drive),
        "velocity": state.velocity.copy(),
        "radius": parameters.radius.copy(),
        "species": parameters.species.copy(),
        **_slots(parameters, step, tension),
    }
    numbers = {
        "elastic_energy": float(stored_energy(parameters.contacts, step.pairs, step.films, state.position)),
        "smallest_gap": float(np.exp(step.log_gap.min(initial=np.inf))),
        "largest_tension": float(tension.max(initial=0.0)),
        "largest_compression": float((-tension).max(initial=0.0)),
        "load": drive.load,
        "contacts": float(len(tension)),
        "time_steps": float(state.tally[ACCEPTED]),
        "rejected_steps": float(state.tally[REJECTED] + state.tally[FAILED]),
    }
    units = UNITS
    if parameters.box.any():
        numbers |= _box_numbers(parameters, step, drive)
        units = UNITS | dict.fromkeys(("pressure", "shear_stress", "normal_stress"), STRESS[parameters.dimensions])
        units |= dict.fromkeys(("box_width", "box_height"), "m")
    return Frame(float(state.pace[CLOCK]), arrays, numbers, units)


def at_home(parameters: Parameters, position: Array, drive: Drive) -> Array:
    """Places within the box; as they are where there is none."""
    dimensions = position.shape[1]
    box = parameters.box[:dimensions] * drive.scale
    away = wraps(position, box, drive.strain)
    places = position - away * box
    places[:, 0] -= drive.strain * box[1] * away[:, 1]
    return np.asarray(places)


def stress(step: Step, volume: float, dimensions: int) -> Array:
    """The stress, tension positive: (1/V) sum of F_ij X_ij over contacts."""
    between = step.bodies.position[step.pairs.second] - step.bodies.position[step.pairs.first]
    between = between + step.pairs.offset[:, :dimensions]
    return np.asarray(step.answers.force[:, :dimensions].T @ between / volume)


def _box_numbers(parameters: Parameters, step: Step, drive: Drive) -> dict[str, float]:
    dimensions = parameters.dimensions
    sides = parameters.box[:dimensions] * drive.scale
    tensor = stress(step, float(np.prod(sides)), dimensions)
    filled = np.pi * parameters.radius**2 if dimensions == 2 else 4.0 / 3.0 * np.pi * parameters.radius**3
    return {
        "pressure": -float(np.trace(tensor)) / dimensions,
        "shear_stress": float(tensor[0, 1] + tensor[1, 0]) / 2.0,
        "normal_stress": -float(tensor[1, 1]),
        "strain": drive.strain,
        "box_width": float(sides[0]),
        "box_height": float(sides[1]),
        "volume_fraction": float(filled.sum() / np.prod(sides)),
    }


def _slots(parameters: Parameters, step: Step, tension: Array) -> dict[str, Array | Integers]:
    """Contacts as arrays of the spheres: each stands at the sphere of lower number; -1 where there is none."""
    first, count = step.pairs.first, len(parameters.radius)
    slots = min(SLOTS[parameters.dimensions], max(count - 1, 1))
    order = np.lexsort((step.log_gap, first))
    place = np.arange(len(first)) - np.searchsorted(first[order], first[order])
    told, place = order[place < slots], place[place < slots]
    shear = step.answers.force[told] - tension[told, None] * step.direction[told]
    values = {
        "neighbor": step.pairs.second[told],
        "gap": np.exp(step.log_gap[told]),
        "tension": tension[told],
        "shear": np.linalg.norm(shear, axis=1),
    }
    arrays: dict[str, Array | Integers] = {}
    for name, column in values.items():
        arrays[name] = np.full((count, slots), -1, np.int64) if name == "neighbor" else np.zeros((count, slots))
        arrays[name][first[told], place] = column
    return arrays
