"""What `ecume check` says of a liquid before it runs: how well it is resolved, what it costs, what would be better."""

from __future__ import annotations

import itertools
import math

import numpy as np

from ecume.laws.kernels import KERNELS
from ecume.models.check_report import LONG, Row, told_duration, with_prefix
from ecume.models.frame_cost import Content, frame_cost, told_size
from ecume.models.last_frame import last_step
from ecume.models.sph import time_step
from ecume.models.sph.color import NODES
from ecume.models.sph.defaults import sides_of, smallest_extent, smoothing_of, tension_of
from ecume.models.sph.parameters import Parameters
from ecume.models.sph.regimes import regime_rows
from ecume.models.sph.solids import solids_of
from ecume.models.sph.substances import material_rows
from ecume.models.sph.tension import TENSIONS
from ecume.scenes.sph import SphScene

PAIRS_PER_SECOND = 1.5e8
"""Of the sums, on one core: a rough figure."""
NODES_PER_SECOND = 1e8
"""Of the color and its forces."""
OVERHEAD = 3e-4
"""Seconds of a step that do not depend on how many particles there are."""
NUMBERS = 38
"""Numbers in a frame of a tank, about."""
FEW_NEIGHBORS, MANY_NEIGHBORS = {2: 12, 3: 30}, {2: 80, 3: 250}
PAIRING = {2: 25, 3: 65}
"""Neighbors above which particles of a kernel whose Fourier transform turns negative come to lie in pairs
[dehnen2012].
"""
COARSE, FINE = 8, 20
"""Particles across the smallest extent: a first look, and what pressures can be read from."""
FAST = 0.11
"""The Mach number above which a liquid is compressed by more than a percent or so."""


def advice(scene: SphScene, parameters: Parameters, count: int, bytes_each: float) -> list[Row]:
    """Everything there is to say of a scene with so many particles."""
    return [
        *_resolution(scene, parameters, count),
        *_liquid(scene, parameters),
        *_tension(scene, parameters),
        *regime_rows(scene, parameters),
        *_cost(scene, parameters, count, bytes_each),
    ]


def _resolution(scene: SphScene, parameters: Parameters, count: int) -> list[Row]:
    spacing, smoothing = scene.spacing, smoothing_of(scene)
    walls = parameters.boundary.dummies.position.shape[1]
    across, neighbors = particles_across(scene), lattice_neighbors(parameters.dimension, parameters.support / spacing)
    return [
        ("particles", str(count), walls_remark(scene, walls)),
        ("resolution", f"{across:.0f} particles", f"across the liquid's smallest extent; {resolution_remark(across)}"),
        ("smoothing length", with_prefix(smoothing, "m"), f"{smoothing / spacing:.3g} spacings"),
        ("neighbors", str(neighbors), neighbor_remark(neighbors, parameters.dimension, scene.method.kernel)),
        *thin_solids(scene, parameters),
    ]


def walls_remark(scene: SphScene, dummies: int) -> str:
    """What holds the liquid."""
    if dummies:
        return f"{dummies} more in walls and solids"
    if all(side.kind != "wall" for side in sides_of(scene)):
        return "no walls"
    return "walls only reflect" if scene.tank.walls == "reflect" else "walls are mirrors"


def thin_solids(scene: SphScene, parameters: Parameters) -> list[Row]:
    """Obstacles and bodies thinner than the support: the liquid on either side feels the other, and dummies are few."""
    solids = solids_of(scene)
    names = parameters.boundary.names[len(parameters.boundary.names) - len(solids) :]
    support = parameters.support / scene.spacing
    thin = [(name, solid.thickness() / scene.spacing) for name, solid in zip(names, solids, strict=True)]
    fault = f"thinner than the support, {support:.3g}: liquid feels the other side, the standoff and the guard hold it"
    return [(name, f"{thick:.3g} spacings thick", fault) for name, thick in thin if thick < support * (1.0 - 1e-9)]


def _liquid(scene: SphScene, parameters: Parameters) -> list[Row]:
    material = parameters.material
    mach = material.fastest / material.sound_speed
    remark = "to be expected" if mach <= FAST else "large: raise liquid.sound_speed"
    return [
        *material_rows(scene.liquid),
        (
            "fastest speed",
            with_prefix(material.fastest, "m/s"),
            "" if scene.liquid.fastest else "expected; say liquid.fastest",
        ),
        ("sound speed", f"{material.sound_speed:.4g} m/s", "of the numerical liquid"),
        ("Mach number", f"{mach:.2g}", "to be expected"),
        ("compression", f"{100.0 * mach**2:.2g} %", remark),
    ]


def _tension(scene: SphScene, parameters: Parameters) -> list[Row]:
    model = tension_of(scene)
    return (
        [] if model == "none" else [("surface", f"tension by {model}", TENSIONS[model].accuracy[parameters.dimension])]
    )


def _cost(scene: SphScene, parameters: Parameters, count: int, bytes_each: float) -> list[Row]:
    steps = last_step(scene, parameters.steps_per_frame)
    stepping = steps * seconds_a_step(scene, parameters, count)
    cost = frame_cost(scene, Content(count, (parameters.dimension, parameters.dimension, 1, 1, 1, 1), NUMBERS))
    seconds = stepping + cost.seconds
    saves = 2 ** (parameters.dimension + 1)
    long = f"; a spacing twice as wide takes 1/{saves}" if seconds > LONG else ""
    return [
        (
            "time step",
            with_prefix(parameters.time_step, "s", 3),
            f"{limiter(scene, parameters)}; divided where the flow asks for it",
        ),
        ("steps", str(steps), f"{parameters.steps_per_frame} per frame"),
        *cost.rows(),
        ("memory", told_size(count * bytes_each), f"{bytes_each:.0f} bytes a particle"),
        ("time on this machine", told_duration(seconds), f"roughly, after compilation{long}{cost.remark(stepping)}"),
    ]


def seconds_a_step(scene: SphScene, parameters: Parameters, count: int) -> float:
    """Two sums over neighbors, and for the continuum surface force two over the nodes around each particle."""
    neighbors = lattice_neighbors(parameters.dimension, parameters.support / scene.spacing)
    reach = parameters.color_reach / (NODES * scene.spacing)
    nodes = math.pi * reach**2 * (1.0 if parameters.dimension == 2 else 4.0 / 3.0 * reach)
    return 2.0 * (count * (neighbors / PAIRS_PER_SECOND + nodes / NODES_PER_SECOND) + OVERHEAD)


def particles_across(scene: SphScene) -> float:
    """The smallest extent of any region, in spacings."""
    return smallest_extent(scene) / scene.spacing


def resolution_remark(across: float) -> str:
    """Whether that is enough."""
    if across < COARSE:
        return f"coarse: a first look; {COARSE} or more show the flow"
    return "fine" if across >= FINE else f"good for the flow; {FINE} or more for pressures"


def lattice_neighbors(dimension: int, reach: float) -> int:
    """Points of a square lattice closer to one of them than `reach` spacings, itself not counted.

    >>> lattice_neighbors(2, 4.0)
    44
    """
    line = range(-math.ceil(reach), math.ceil(reach) + 1)
    away = np.array(list(itertools.product(line, repeat=dimension)))
    return int(((away**2).sum(axis=1) < reach**2 * (1.0 - 1e-12)).sum()) - 1


def neighbor_remark(neighbors: int, dimension: int, kernel: str) -> str:
    """Whether that is a good number for this kernel."""
    if neighbors < FEW_NEIGHBORS[dimension]:
        return "few, sums are rough: raise method.smoothing"
    if neighbors > MANY_NEIGHBORS[dimension]:
        return "many, each costs: lower method.smoothing"
    if neighbors > PAIRING[dimension] and KERNELS[kernel].pairing:
        return f"so many that particles pair with {kernel}: lower method.smoothing, or take wendland-c2"
    return "good"


def limiter(scene: SphScene, parameters: Parameters) -> str:
    """What sets the step."""
    if scene.method.time_step is not None:
        return "as given"
    return f"set by {time_step.limiter(time_step.limits_of(scene, parameters.material))}"
