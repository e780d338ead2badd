"""The packing as a porous medium: the quantities of a scene on which the permeation of the liquid depends."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ecume.laws.permeability import PERMEABILITIES
from ecume.models.law_codes import code_of
from ecume.models.liquids import material_of
from ecume.scenes.soft import SIDES, PermeationSpec, SoftScene, sides_of
from ecume.units import Array

LAYER = 2.0
"""The default height of a layer, in mean diameters."""
OPEN = -1
"""In place of a wall: an end of the layers where the liquid is open, or a flux that no wall prescribes."""


class Medium(NamedTuple):
    """Constants of the permeation, for compiled code."""

    axis: int
    """across the walls with `drained`"""
    lower: int
    upper: int
    """the walls at both ends of the layers, or OPEN"""
    closed: int
    """the undrained wall, whose velocity is the flux of liquid and spheres; OPEN where both ends are drained"""
    layers: int
    height: float
    """m: from the wall to an open end"""
    section: float
    """m, in 3D m^2: the cross-section of the layers, over which stresses act"""
    area: float
    """m^2: that of the liquid; in 2D the spheres have a layer of the height of their mean diameter"""
    viscosity: float
    """Pa s"""
    radius: Array
    volume: Array
    """(N,) m^3"""
    surface: Array
    """(N,) m^2"""
    law: int
    """the code of a row of `ecume.laws.permeability.PERMEABILITIES`"""
    permeability: float
    """m^2, where the scene gives it"""


def medium_of(scene: SoftScene, radius: Array) -> Medium | tuple[()]:
    """The medium of a scene; empty without permeation."""
    spec = scene.permeation
    if spec is None:
        return ()
    ends = {SIDES[wall.side]: place for place, wall in enumerate(scene.walls) if wall.drained is not None}
    axis = next(iter(ends))[0]
    lower, upper = (ends.get((axis, side), OPEN) for side in (-1.0, 1.0))
    undrained = [place for place in (lower, upper) if place != OPEN and scene.walls[place].drained is False]
    sides, diameter = sides_of(scene), 2.0 * float(radius.mean())
    begin, end = _ends(scene, axis)
    section = math.prod(sides) / sides[axis]
    return Medium(
        axis=axis,
        lower=lower,
        upper=upper,
        closed=undrained[0] if undrained else OPEN,
        layers=layers_of(spec, end - begin, diameter),
        height=end - begin,
        section=section,
        area=section * (diameter if len(sides) == 2 else 1.0),
        viscosity=material_of(scene.liquid).viscosity,
        radius=radius,
        volume=4.0 / 3.0 * np.pi * radius**3,
        surface=4.0 * np.pi * radius**2,
        law=code_of(PERMEABILITIES, spec.law),
        permeability=spec.permeability or 0.0,
    )


def _ends(scene: SoftScene, axis: int) -> tuple[float, float]:
    """The ends of the layers at the start (m)."""
    found = [0.0, sides_of(scene)[axis]]
    for wall in scene.walls:
        across, outward = SIDES[wall.side]
        if across == axis and wall.position is not None:
            found[outward > 0.0] = wall.position
    return found[0], found[1]


def layers_of(spec: PermeationSpec, height: float, diameter: float) -> int:
    """The number of equal layers whose height is as near as possible to the given one."""
    return max(round(height / (spec.layer_height or LAYER * diameter)), 1)
