"""Floating bodies beside the sphere and the disc: a bubble, cylinders that stand and that lie, an ellipsoid."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ecume.errors import BadInput
from ecume.laws.arguments import require_angle, require_positive
from ecume.laws.flotation.bodies import Disc, Liquid
from ecume.units import Angle, Density, Length


@dataclass(frozen=True)
class Bubble:
    """A gas bubble under the surface, of the gas above it; the radius is that of a sphere of its volume.

    >>> Bubble(radius=5e-4).radius
    0.0005
    """

    radius: Length

    def __post_init__(self) -> None:
        require_positive("bubble's radius", self.radius)


@dataclass(frozen=True)
class VerticalCylinder:
    """A cylinder that stands upright: the contact line slides on its side, and is pinned when it comes to a rim.

    Whether it would rather lie down is not asked.

    >>> VerticalCylinder(radius=1e-3, height=4e-3, density=500.0, contact_angle=1.2).height
    0.004
    """

    radius: Length
    height: Length
    density: Density
    contact_angle: Angle

    def __post_init__(self) -> None:
        for name in ("radius", "height", "density"):
            require_positive(f"cylinder's {name}", getattr(self, name))
        require_angle("cylinder's contact_angle", self.contact_angle)


@dataclass(frozen=True)
class HorizontalCylinder:
    """A long cylinder that lies in the surface; everything about it is for a piece in its middle, in two dimensions.

    >>> HorizontalCylinder(radius=1e-3, density=1200.0, contact_angle=1.5).density
    1200.0
    """

    radius: Length
    density: Density
    contact_angle: Angle

    def __post_init__(self) -> None:
        for name in ("radius", "density"):
            require_positive(f"cylinder's {name}", getattr(self, name))
        require_angle("cylinder's contact_angle", self.contact_angle)


@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid with one axis upright: semi-axes along x, along y, and upright.

    Its mean contact line is taken for that of the spheroid whose horizontal semi-axes are sqrt(a b): exact for a = b.

    >>> Ellipsoid(semi_axes=(2e-3, 1e-3, 1e-3), density=1100.0, contact_angle=1.2).semi_axes
    (0.002, 0.001, 0.001)
    """

    semi_axes: tuple[Length, Length, Length]
    density: Density
    contact_angle: Angle

    def __post_init__(self) -> None:
        object.__setattr__(self, "semi_axes", tuple(self.semi_axes))
        if len(self.semi_axes) != 3:
            raise BadInput(
                f"the ellipsoid's semi_axes are {self.semi_axes!r}; expected three: along x, along y, upright"
            )
        for length in self.semi_axes:
            require_positive("ellipsoid's semi-axis", length)
        require_positive("ellipsoid's density", self.density)
        require_angle("ellipsoid's contact_angle", self.contact_angle)


def disc_of_cylinder(cylinder: VerticalCylinder, liquid: Liquid, rim: str = "top") -> Disc:
    """A flat-bottomed cylinder as a disc that is pinned at one of its rims, "top" or "bottom".

    Load and stability follow from its weight, and from the volume below that rim. [keller1998].

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> coin = VerticalCylinder(radius=5e-3, height=1e-3, density=2700.0, contact_angle=1.2)
    >>> hung = disc_of_cylinder(coin, water)
    >>> hung.load > 0 > hung.stability
    True
    """
    if rim not in ("top", "bottom"):
        raise BadInput(f"got rim {rim!r}; expected top or bottom")
    volume = math.pi * cylinder.radius**2 * cylinder.height
    weight = (cylinder.density - liquid.gas_density) * liquid.gravity * volume
    displaced = liquid.density_difference * liquid.gravity * volume if rim == "top" else 0.0
    lever = -0.5 * cylinder.height if rim == "top" else 0.5 * cylinder.height
    moment = weight * lever + displaced * 0.5 * cylinder.height
    stability = moment / (liquid.surface_tension * liquid.capillary_length**2)
    return Disc(cylinder.radius, weight - displaced, stability=stability)
