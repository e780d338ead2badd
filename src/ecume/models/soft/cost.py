"""What steps of soft spheres cost, and how many there will be: numbers that were measured, all in this place.

On one core of a Xeon of 2.x GHz with other work beside it (`benchmarks/README.md`): steps a unit of strain of sheared
packings, 10^3 to 10^5 spheres; steps of the templates `soft-two-spheres` and `t1` at tolerances of 1e-3 to 1e-7.
"""

from __future__ import annotations

import numpy as np

from ecume.models.soft.parameters import Parameters
from ecume.models.soft.schemes import SCHEMES
from ecume.models.soft.solving import FEW
from ecume.scenes.soft import SoftScene

MANY = 1000
"""Spheres whose number of steps in a unit of strain does not grow further; of fewer it is as the third root of their
number: 330 were taken by 36 spheres, 600 by 100.
"""
FEW_SPHERES, PASSES = 2e-4, 3e-3
"""Seconds of a step besides: compiled as a whole, and with each pass over the spheres called by itself."""
BYTES, COMPILER = 3000.0, 3.5e8
"""Memory of a film, with the sphere that it belongs to, and of all besides."""


def steps_of(scene: SoftScene, parameters: Parameters) -> float:
    """How many steps there will be, roughly: those of a relaxation at each turn of the protocol, and of all strain."""
    protocol, end = parameters.protocol, scene.duration
    turns = int((protocol.times < end).sum())
    scheme = SCHEMES[parameters.scheme]
    finer = (1e-3 / parameters.tolerance) ** scheme.refinement
    straining = scheme.straining * min(len(parameters.radius) / MANY, 1.0) ** (1.0 / 3.0)
    steps = finer * (scheme.relaxing * turns + straining * strain_of(parameters, end))
    return float(max(steps, scene.duration / scene.frame_every))


def strain_of(parameters: Parameters, end: float) -> float:
    """All that the box is sheared and sized by until a time, back and forth; walls that go along count by a height."""
    protocol, total = parameters.protocol, 0.0
    spans = np.diff(np.append(np.minimum(protocol.times, end), end))
    for (_, strain, scale, height, *_), wave, span in zip(protocol.courses, protocol.waves, spans, strict=True):
        rates = abs(strain[1]) + abs(scale[1]) / scale[0] + abs(height[1])
        # A sine's mean speed is two over pi of its largest.
        total += span * (rates + 2.0 / np.pi * wave[0] * wave[2])
    moving = np.abs(parameters.walls.velocity).max(initial=0.0)
    return float(total + moving * end / (10.0 * parameters.radius.max()))


def seconds_of(parameters: Parameters, contacts: int) -> float:
    """Of a step with so many films."""
    few = parameters.force.size + parameters.torque.size <= FEW
    return (FEW_SPHERES if few else PASSES) + contacts * SCHEMES[parameters.scheme].seconds


def bytes_of(contacts: float) -> float:
    """At the most, in a run with so many films."""
    return COMPILER + BYTES * contacts
