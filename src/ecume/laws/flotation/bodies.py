"""Liquids, bodies that float on them, and the dimensionless numbers of their equilibrium."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ecume.errors import BadInput
from ecume.laws.arguments import elementwise, require_angle, require_finite, require_not_negative, require_positive
from ecume.units import Acceleration, Angle, Density, Force, Length, Number, SurfaceTension, Viscosity


@dataclass(frozen=True)
class Liquid:
    """A liquid under a gas or a second liquid: density, surface tension, viscosity and gravity, with density and
    viscosity of the gas.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> round(water.capillary_length * 1e3, 3)
    2.709
    """

    density: Density
    surface_tension: SurfaceTension
    viscosity: Viscosity
    gravity: Acceleration = 9.81
    gas_density: Density = 0.0
    gas_viscosity: Viscosity = 0.0

    def __post_init__(self) -> None:
        for name in ("density", "surface_tension", "gravity"):
            require_positive(f"liquid's {name}", getattr(self, name))
        require_not_negative("liquid's viscosity", self.viscosity)
        require_not_negative("liquid's gas_density", self.gas_density)
        require_not_negative("liquid's gas_viscosity", self.gas_viscosity)
        if self.gas_density >= self.density:
            raise BadInput(
                f"gas_density {self.gas_density:g} kg/m^3 is not below the liquid's density {self.density:g} kg/m^3; "
                "the liquid is what lies below"
            )

    @property
    def density_difference(self) -> Density:
        """Density of the liquid minus that of the gas above it, on which gravity acts."""
        return self.density - self.gas_density

    @property
    def viscosity_of_both(self) -> Viscosity:
        """Sum of the viscosities below and above the surface, the reference of drag on floats."""
        return self.viscosity + self.gas_viscosity

    @property
    def share_above(self) -> Number:
        """Fraction of `viscosity_of_both` that belongs to the gas above."""
        return self.gas_viscosity / self.viscosity_of_both if self.gas_viscosity > 0.0 else 0.0

    @property
    def capillary_length(self) -> Length:
        """Capillary length L = sqrt(gamma / (drho g)), the range of a meniscus."""
        return math.sqrt(self.surface_tension / (self.density_difference * self.gravity))


@dataclass(frozen=True)
class Sphere:
    """A sphere of one material; the contact angle is measured through the liquid, 0 when wetted, pi when not.

    >>> Sphere(radius=1e-3, density=1300.0, contact_angle=1.5).radius
    0.001
    """

    radius: Length
    density: Density
    contact_angle: Angle

    def __post_init__(self) -> None:
        require_positive("sphere's radius", self.radius)
        require_positive("sphere's density", self.density, hint="a bubble has the density of its gas")
        require_angle("sphere's contact_angle", self.contact_angle)


@dataclass(frozen=True)
class Disc:
    """A flat body whose contact line is pinned to its round rim: a thin disc, a piece of cereal, a flat-bottomed
    cylinder.

    load: weight minus the buoyancy of the part below the plane of the rim, positive downwards. tilting: whether the
    disc may tilt; otherwise it stays level. stability: kappa = (m g H + rho g V d) / (gamma L^2), with H the height of
    the center of mass above the rim's plane, V and d the volume below it and the depth of its centroid; it makes a tall
    disc tilt more.

    >>> Disc(radius=1.35e-3, load=2e-5).tilting
    True
    """

    radius: Length
    load: Force
    tilting: bool = True
    stability: Number = 0.0

    def __post_init__(self) -> None:
        require_positive("disc's radius", self.radius)
        for name in ("load", "stability"):
            require_finite(f"disc's {name}", getattr(self, name))


def bond_number(sphere: Sphere, liquid: Liquid) -> Number:
    """Bond number B = (R/L)^2: gravity over surface tension. [vella2005]; [canbraun2022, eq. 5] gives it as an
    approximation.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> round(bond_number(Sphere(1e-3, 1300.0, 1.57), water), 5)
    0.13625
    """
    return (sphere.radius / liquid.capillary_length) ** 2


def density_ratio(sphere: Sphere, liquid: Liquid) -> Number:
    """Density ratio D = (rho_s - rho_a) / (rho_l - rho_a), with s the sphere, l the liquid, a the
    gas.

    Erratum: [canbraun2022, eq. 3] has rho_s on one side and rho_l - rho_a on the other; the gas buoys up the dry
    part as well.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> density_ratio(Sphere(1e-3, 1300.0, 1.57), water)
    1.3
    """
    return (sphere.density - liquid.gas_density) / liquid.density_difference


@elementwise
def weight_number(density_ratio: Number, contact_angle: Angle) -> Number:
    """Dimensionless weight Sigma = (2D - 1)/3 - cos(theta)/2 + cos(theta)^3/6: weight minus the buoyancy at a flat
    surface.

    2 pi gamma R B Sigma is the force that the surface has to carry. [vella2005]; [canbraun2022, eq. 4].

    >>> weight_number(0.5, math.pi / 2) < 1e-15
    True
    """
    cosine = math.cos(contact_angle)
    return (2.0 * density_ratio - 1.0) / 3.0 - cosine / 2.0 + cosine**3 / 6.0


def dimensionless_weight(sphere: Sphere, liquid: Liquid) -> Number:
    """Dimensionless weight Sigma of a sphere on a liquid: positive if it depresses the surface. See
    `weight_number`.

    >>> water = Liquid(density=1000.0, surface_tension=0.072, viscosity=1e-3)
    >>> round(dimensionless_weight(Sphere(1e-3, 1500.0, math.pi / 2), water), 12)
    0.666666666667
    """
    return weight_number(density_ratio(sphere, liquid), sphere.contact_angle)


def young_contact_angle(
    *, solid_gas: SurfaceTension, solid_liquid: SurfaceTension, liquid_gas: SurfaceTension
) -> Angle:
    """Contact angle from the three surface tensions: cos(theta) = (gamma_sg - gamma_sl) / gamma_lg. [young1805].

    >>> round(math.degrees(young_contact_angle(solid_gas=0.06, solid_liquid=0.024, liquid_gas=0.072)), 9)
    60.0
    """
    require_positive("liquid_gas tension", liquid_gas)
    require_finite("solid_gas tension", solid_gas)
    require_finite("solid_liquid tension", solid_liquid)
    cosine = (solid_gas - solid_liquid) / liquid_gas
    if not -1.0 <= cosine <= 1.0:
        state = "the liquid spreads, contact angle 0" if cosine > 1.0 else "the liquid draws back, contact angle pi"
        raise BadInput(
            f"no contact angle has the cosine {cosine:.4g} = ({solid_gas:g} - {solid_liquid:g}) / {liquid_gas:g}; "
            f"{state}"
        )
    return math.acos(cosine)


@dataclass(frozen=True)
class Bubble:
    """A gas bubble below the surface, of the gas above it; the radius is that of a sphere of its
    volume.

    >>> Bubble(radius=5e-4).radius
    0.0005
    """

    radius: Length

    def __post_init__(self) -> None:
        require_positive("bubble's radius", self.radius)


@dataclass(frozen=True)
class VerticalCylinder:
    """An upright cylinder: its contact line slides on its side and is pinned at a rim.

    The stability of the upright orientation is not checked.

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
    """A long cylinder that lies in the surface; all quantities are for a slice in its middle, in
    2D.

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

    Its mean contact line is approximated by that of the spheroid whose horizontal semi-axes are sqrt(a b): exact for a
    = b.

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
    """The disc that represents a flat-bottomed cylinder pinned at one of its rims, "top" or
    "bottom".

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
