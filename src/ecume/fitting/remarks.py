"""Remarks of a fit on its tracks and on itself, beside the numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import linear_sum_assignment

from ecume.fitting.initial_conditions import first_frame
from ecume.fitting.least_squares import Certainty, Problem, values_at
from ecume.fitting.tracks import Tracks
from ecume.units import Array
from ecume.value_texts import with_prefix

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

MEMORY = 0.5
"""The correlation of neighboring residuals beyond which they are no noise."""
TOUCHING = 0.005
"""The gap, over both radii, below which two particles count as touching."""
MOST_PAIRED = 1000
"""Particles whose pairs are looked at one by one."""
SHOWN = 0.1
"""The least power of a parameter in a combination that is printed."""
SHORTER = 0.3
"""The part of their way, in squares, that is left where two objects exchange names: then they had been exchanged."""
MOST_ASTRAY = 0.1
"""Of the measurements; where more are far off it is not they that are wrong."""
ASTRAY = 6.0
"""So many times the median residual a measurement is no noise: of Gaussian noise one in 1e10 would be."""


def swapped(tracks: Tracks) -> list[str]:
    """A remark where objects seem to exchange names, as when a tracking program mixes them up.

    From instant to instant the sum of all displacements is the smallest possible, or a name is wrong.
    """
    if len(tracks.names) > MOST_PAIRED:
        return []
    for before, after in zip(range(len(tracks.times)), range(1, len(tracks.times)), strict=False):
        here, there = tracks.position[before], tracks.position[after]
        both = np.flatnonzero(np.isfinite(here[:, 0]) & np.isfinite(there[:, 0]))
        ways = np.sum((here[both][:, None] - there[both][None]) ** 2, axis=2)
        order = linear_sum_assignment(ways)[1]
        if ways[range(len(both)), order].sum() < SHORTER * np.trace(ways):
            names = ", ".join(tracks.names[both[place]] for place in range(len(both)) if order[place] != place)
            return [f"objects {names} seem to swap names at t = {tracks.times[after]:.4g} s; correct the tracks"]
    return []


def astray(problem: Problem, left: Array) -> list[str]:
    """A remark where single measurements lie far from where all others would have them."""
    off = np.linalg.norm(left, axis=2)
    far = np.flatnonzero(off[problem.seen] > ASTRAY * np.median(off[problem.seen]))
    if len(far) == 0 or len(far) > MOST_ASTRAY * problem.seen.sum():
        return []
    instants, objects = (places[far] for places in np.nonzero(problem.seen))
    worst = int(np.argmax(off[instants, objects]))
    who, when = problem.tracks.names[objects[worst]], problem.tracks.times[instants[worst]]
    more = f", and {len(far) - 1} more" if len(far) > 1 else ""
    size = f"{with_prefix(off[instants[worst], objects[worst]], 'm', 2)}"
    return [f"object {who} is {size} off at t = {when:.4g} s{more}: more than noise; delete such lines"]


def unsure(problem: Problem, at: Array, sure: Certainty) -> list[str]:
    """The combinations of the parameters that the tracks do not determine, and those that they do."""
    loose, count = ~sure.determined, len(sure.errors)
    if not loose.any():
        return []
    message = (
        f"the tracks determine {count - int(loose.sum())} of {count} combinations; "
        f"undetermined: {'; '.join(_combination(problem, at, row) for row in sure.directions[loose])}"
    )
    known = [
        f"{_combination(problem, at, row)} to {100.0 * sure.quantile * error:.2g} %"
        for row, error in zip(sure.directions[~loose], sure.errors[~loose], strict=True)
    ]
    hint = ["hold one of them fixed to know the others"] if count > 1 else []
    return [message, *([f"determined: {'; '.join(known)}"] if known else []), *hint]


def _combination(problem: Problem, at: Array, direction: Array) -> str:
    """A direction as a product of powers: its logarithm changes along it, and not across it.

    The logarithm of p1^a p2^b has the slopes a and b in ln(p); one coordinate's slope is a part of ln(p)'s.
    """
    values = values_at(problem, at)
    powers = [part / free.steepness(value) for part, free, value in zip(direction, problem.free, values, strict=True)]
    largest = max(powers, key=abs)
    shares = [(free.name, power / largest) for free, power in zip(problem.free, powers, strict=True)]
    shown = [(name, share) for name, share in shares if abs(share) >= SHOWN]
    return " ".join(name if abs(share - 1.0) < 5e-3 else f"{name}^{share:.2g}" for name, share in shown)


def met(scene: Scene, times: Array, there: Array) -> list[str]:
    """A remark where particles touch: when they do is known to a step, so that the residuals are rough from then on."""
    if scene.model != "floating":  # soft spheres deform, tracers do not feel one another
        return []
    radius = first_frame(scene).arrays["radius"]
    if len(radius) > MOST_PAIRED:
        return []
    one, other = np.triu_indices(len(radius), 1)
    gap = np.linalg.norm(there[:, one] - there[:, other], axis=2) - radius[one] - radius[other]
    touching = (gap < TOUCHING * (radius[one] + radius[other])).any(axis=1)
    if not touching.any():
        return []
    when = float(times[np.argmax(touching)])
    return [f"particles touch at t = {when:.4g} s; later data say little and make the fit rough; use --until"]


def no_noise(problem: Problem, left: Array) -> list[str]:
    """A remark if residuals are correlated in time: then the scene lacks an effect, and intervals are too narrow."""
    seen = problem.seen
    both = seen[1:] & seen[:-1]
    one, other = left[:-1][both].ravel(), left[1:][both].ravel()
    size = float(np.sqrt(np.sum(one**2) * np.sum(other**2)))
    if len(one) < 20 or size == 0.0 or float(np.sum(one * other)) / size < MEMORY:
        return []
    return ["the residuals are not noise but correlated in time: the scene lacks an effect; intervals are too narrow"]
