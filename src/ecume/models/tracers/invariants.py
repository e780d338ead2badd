"""What tracers must not lose: anybody, and energy that nobody brings."""

from __future__ import annotations

from ecume.models.invariants import Invariant, Numbers, Seen, energy_never_rises
from ecume.models.tracers.parameters import Parameters
from ecume.scenes.tracers import TracersScene

RISE = 1e-6
"""Of the energy: flights between walls are exact."""


def invariants(scene: TracersScene, parameters: Parameters) -> list[Invariant]:
    """The rows of a scene. What the liquid and openings bring is booked, see `work`."""
    everyone = Invariant("mass", "particles that are neither inside nor gone through an opening", 0.0, _missing)
    return [everyone, energy_never_rises(RISE)]


def _missing(seen: Seen) -> float:
    """Of those that were there at the start or came in since."""
    came = _through("came", seen.now) - _through("came", seen.first)
    gone = _through("left", seen.now) - _through("left", seen.first)
    return abs(seen.first["particles_inside"] + came - gone - seen.now["particles_inside"])


def _through(way: str, numbers: Numbers) -> float:
    return sum(value for name, value in numbers.items() if name.startswith(f"{way}_through_opening_"))
