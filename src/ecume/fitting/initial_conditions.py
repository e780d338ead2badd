"""The initial positions of tracked objects in a scene, and the assignment of objects to particles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from ecume.errors import BadInput
from ecume.fitting.tracks import Tracks
from ecume.simulation import simulate
from ecume.trajectories.frame import Frame
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

FIRST = 5
"""Instants from which the speed at the start is guessed."""


def first_frame(scene: Scene) -> Frame:
    """The scene's own start."""
    frame = next(simulate(scene))
    if frame.arrays["position"].shape[1] != 2:
        raise BadInput("tracks are 2D; the particles of the scene move in 3D")
    return frame


def matched(tracks: Tracks, frame: Frame, *, centered: bool) -> Tracks:
    """The tracks in the order of the scene's particles: each is the one that starts nearest to it.

    `centered`: but for a shift of all of them together. Raises BadInput unless there are as many.
    """
    there = frame.arrays["position"]
    if len(there) != len(tracks.names):
        hint = "; name those that count (--only), and join what an object left that was lost and found again"
        raise BadInput(
            f"there are {len(tracks.names)} tracks and {len(there)} particles in the scene; expected the same number"
            + hint * (len(tracks.names) > len(there))
        )
    seen = first_seen(tracks)
    if centered:
        there, seen = there - there.mean(axis=0), seen - seen.mean(axis=0)
    apart = np.linalg.norm(there[:, None] - seen[None], axis=2)
    order = linear_sum_assignment(apart**2)[1]
    return Tracks(tuple(tracks.names[place] for place in order), tracks.times, tracks.position[:, order])


def first_seen(tracks: Tracks) -> Array:
    """(N, 2) m: where each object was seen first."""
    seen = np.isfinite(tracks.position[:, :, 0])
    return np.array([tracks.position[np.argmax(seen[:, n]), n] for n in range(len(tracks.names))])


def first_speeds(tracks: Tracks) -> Array:
    """(N, 2) m/s: the slopes of straight lines through the first instants of each object."""
    return np.array([_slope(tracks.times, tracks.position[:, n]) for n in range(len(tracks.names))])


def _slope(times: Array, position: Array) -> Array:
    seen = np.flatnonzero(np.isfinite(position[:, 0]))[:FIRST]
    if len(seen) < 2:
        return np.zeros(2)
    return np.asarray(np.polyfit(times[seen], position[seen], 1)[0])


def start_at(plain: dict[str, Any], position: Array, velocity: Array | None) -> dict[str, Any]:
    """Let the particles of a scene's plain data start there; changes the data and gives it back."""
    require_starts(plain, moving=velocity is not None)
    STARTED[plain["model"]](plain, position, velocity)
    return plain


def require_starts(plain: Mapping[str, Any], *, moving: bool) -> None:
    """Raise BadInput where the start of the scene's model cannot be fitted along."""
    model = plain["model"]
    if model not in STARTED:
        raise BadInput(f"where particles of the model {model} start is the scene's to say: --start scene")
    if moving and model == "soft":
        raise BadInput("soft spheres have no inertia, and so no velocity to start with: --start positions")
    if moving and any(species["count"] > 1 for species in plain.get("particles", ())):
        raise BadInput("particles of a kind start with one velocity; write [[particles]] for each or --start positions")


def _floats_start(plain: dict[str, Any], position: Array, velocity: Array | None) -> None:
    places = iter(range(len(position)))
    for species in plain["particles"]:
        mine = [next(places) for _ in range(species["count"])]
        species |= {"placement": "random", "spacing": None, "ring_radius": None}
        species["positions"] = position[mine].tolist()
        if velocity is not None:
            species["velocities"] = velocity[mine].tolist()
    for row in plain["rows"]:
        place = next(places)
        row |= dict(zip("xy", position[place].tolist(), strict=True))
        if velocity is not None:
            row |= dict(zip(("vx", "vy"), velocity[place].tolist(), strict=True))


def _tracers_start(plain: dict[str, Any], position: Array, velocity: Array | None) -> None:
    places = iter(range(len(position)))
    for species in plain["particles"]:
        mine = [next(places) for _ in range(species["count"])]
        species |= {"positions": position[mine].tolist(), "low": None, "high": None}
        if velocity is not None:
            species["velocity"] = velocity[mine[0]].tolist()


def _spheres_start(plain: dict[str, Any], position: Array, velocity: Array | None) -> None:
    places = iter(range(len(position)))
    for species in plain["particles"]:
        mine = [next(places) for _ in range(species["count"] or len(species["positions"]))]
        species |= {"positions": position[mine].tolist(), "count": None}


STARTED = {"floating": _floats_start, "tracers": _tracers_start, "soft": _spheres_start}
"""By model: sets the initial positions of particles."""
KINDS = ("particles", "rows")
"""What kinds of particles are called in scenes."""


def keeps_kinds(plain: Mapping[str, Any]) -> bool:
    """Whether all particles of the scene are equal."""
    return sum(len(plain.get(kinds, ())) for kinds in KINDS) == 1


def require_no_chance(plain: Mapping[str, Any]) -> None:
    """Raise BadInput if the motion is stochastic: a simulation does not reproduce the tracks."""
    if plain.get("hydrodynamics", {}).get("brownian"):
        raise BadInput("the scene has Brownian motion, which is random; a fit needs a scene without it")
