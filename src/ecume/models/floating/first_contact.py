"""The estimated time of the first contact, from the attraction and the drag of the closest pair alone.

Other floats, walls and currents are neglected. This rough time shows whether a run is long enough, and its frames
frequent enough, to resolve the contact.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from ecume.laws.drag import schiller_naumann_factor
from ecume.models.expected_events import event_row
from ecume.models.floating.forces.interactions import interactions_of
from ecume.models.floating.forces.pair_forces import law_of, row_of, two_floats
from ecume.models.floating.parameters import Parameters, State, is_driven
from ecume.scenes.floating import FloatingScene
from ecume.units import with_prefix

FINE = 0.01
"""The relative change of gap and speed in a step."""
MOST_STEPS = 4000
FORESEEN = 10.0
"""The time for which a contact is sought, over the duration."""
NEAREST = 4
"""Pairs that are followed: those with the narrowest gaps."""
LEAST = 1e-7
"""The minimum number of relaxation times in a step; with fewer, the effect of drag is lost to rounding."""


def first_contact(parameters: Parameters, state: State, longest: float) -> float:
    """The time of the first contact (s); infinite if no contact is expected within the longest time."""
    gaps = _nearest_gaps(parameters, state)
    if not gaps or min(gaps.values()) <= 0.0:
        return math.inf  # a single float, or contact at the start
    return min(_meeting_time(parameters, state, pair, longest) for pair in gaps)


def _nearest_gaps(parameters: Parameters, state: State) -> dict[tuple[int, int], float]:
    """The gaps (m) of the pairs that may meet first; empty if something other than forces determines the first
    contact.
    """
    floats, row = parameters.floats, row_of(parameters)
    count = len(floats.radius)
    if count < 2 or not row.has_force or np.any(parameters.periods) or parameters.drift.thermal > 0.0:
        return {}
    neighbors = min(count - 1, NEAREST)
    found = cKDTree(state.position).query(state.position, k=neighbors + 1)
    away, other = np.asarray(found[0]), np.asarray(found[1])
    pairs = {
        (min(i, j), max(i, j)): float(distance - floats.radius[i] - floats.radius[j])
        for i in range(count)
        for distance, j in zip(away[i, 1:].tolist(), other[i, 1:].tolist(), strict=True)
    }
    return {pair: pairs[pair] for pair in sorted(pairs, key=lambda pair: pairs[pair])[:NEAREST]}


def _meeting_time(parameters: Parameters, state: State, pair: tuple[int, int], longest: float) -> float:
    """The time at which two floats touch (s): Euler steps that change gap and speed by little."""
    floats, row, law = parameters.floats, row_of(parameters), law_of(parameters)
    i, j = pair
    mass, relaxation = floats.mass[[i, j]], floats.relaxation_time[[i, j]]
    radius, charge = floats.radius[[i, j]], floats.charge[[i, j]]
    own = two_floats(parameters, (float(radius[0]), float(radius[1])), (float(charge[0]), float(charge[1])))
    along = state.position[j] - state.position[i]
    touching, distance = float(radius.sum()), math.hypot(*along)
    along = along / distance
    # Speeds toward one another.
    speed = np.array([float(state.velocity[i] @ along), -float(state.velocity[j] @ along)])
    time = 0.0
    for _ in range(MOST_STEPS):
        gap = distance - touching
        pull = -float(row.force(distance, own, law)) / mass
        if not parameters.scheme.inertia:
            speed = pull * relaxation
        closing = float(speed.sum())
        push = float(np.abs(pull).max())
        by_speed = FINE * gap / abs(closing) if closing else math.inf
        by_force = math.sqrt(2.0 * FINE * gap / push) if push else math.inf
        step = min(max(min(by_speed, by_force), 1e-6 * longest), longest - time)
        if step <= 0.0:
            return math.inf
        if parameters.scheme.inertia:
            # Exact for a constant force; drag may be zero.
            faster = [
                schiller_naumann_factor(2.0 * radius[k] * abs(speed[k]) * parameters.drift.thickness) for k in (0, 1)
            ]
            passed = np.maximum(step / relaxation * faster, LEAST)
            lasting = -np.expm1(-passed) / passed
            mean = speed * lasting + pull * step * (1.0 - lasting) / passed
            speed = speed + (pull * step - speed * passed) * lasting
        else:
            mean = speed
        distance -= step * float(mean.sum())
        time += step
        if distance <= touching * (1.0 + FINE * FINE):
            return time
    return math.inf


def contact_row(scene: FloatingScene, parameters: Parameters, state: State) -> list[tuple[str, str, str]]:
    """The row of `ecume check` on the first contact, with suggested times of frames; whether floats repel or are too
    far apart. It is empty where something else than forces determines the first contact.
    """
    longest = FORESEEN * scene.duration
    time = first_contact(parameters, state, longest)
    if time == math.inf and (apart := _nearest_distance(parameters, state)) > parameters.cutoff:
        far = f"{with_prefix(apart, 'm')} between the nearest two centers, beyond the cutoff: no float attracts another"
        return [("first contact", "not by attraction", far)]
    nearest = min(_nearest_gaps(parameters, state).values(), default=0.0)
    if time == math.inf and nearest > 0.0 and _moved_by_pair_law(parameters):
        cause = "the nearest two floats, alone, repel each other or start too far apart for this duration"
        return [("first contact", f"not within {with_prefix(longest, 's')}", cause)]
    return event_row("first contact", time, (scene.duration, scene.frame_every), "of the nearest two floats, alone")


def _moved_by_pair_law(parameters: Parameters) -> bool:
    """Whether the pair law alone moves floats: no magnets, shapes, undulated discs, own laws, currents or other
    driving.
    """
    parts = interactions_of(parameters)
    plain = all(row.path.startswith("interaction.") and row.inertia(part) is None for part, row in parts)
    return plain and not is_driven(parameters)


def _nearest_distance(parameters: Parameters, state: State) -> float:
    """The smallest distance (m) of the centers of pairs that may meet; zero if something other than forces determines
    the first contact.
    """
    radius = parameters.floats.radius
    gaps = _nearest_gaps(parameters, state)
    return min((gap + float(radius[i] + radius[j]) for (i, j), gap in gaps.items()), default=0.0)
