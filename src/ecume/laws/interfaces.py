"""Laws for the mobility of the two surfaces of a film, which determines the friction of the film.

Each law gives the friction of the film against squeezing and shear, and the exponents of contact size and gap in them,
which an implicit step requires. Prefactors c_n and c_t are those of rigid surfaces (`ecume.laws.soft_pair`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, NamedTuple

from ecume.laws.soft_pair import entrained_force, shear_friction, squeeze_friction
from ecume.laws.surfaces import Body
from ecume.units import Force, Friction, Length, Number, Unit, Viscosity

HARDLY = 1e-3
"""The fraction of a rigid film's shear friction that a mobile film keeps, so that its surfaces relax fast but not
instantaneously.
"""
QUIET = 1e-6
"""The tangential force, over modulus times R*^2, below which elastohydrodynamic friction is
independent of the force.
"""

PerForce = Annotated[float, Unit("1/N")]


def extension_friction(contact_size: Length, gap: Length, viscosity: Viscosity) -> Friction:
    """Friction 3 pi eta a^2/h of squeezing a film between surfaces that slip freely: force over speed of approach.

    The film is a disc of liquid in uniform extension, whose normal stress is three times viscosity times rate
    (Trouton). For round bubbles, a^2 = 2R* h, it is independent of the gap; the exact friction has a logarithm that the
    model omits. [trouton1906].

    >>> round(extension_friction(0.1, 0.01, 1.0) / math.pi, 12)
    3.0
    """
    return 3.0 * math.pi * viscosity * contact_size**2 / gap


def mobility(contact_size: Length, gap: Length, viscosity_ratio: Number) -> Number:
    """Mobility m = (1/lambda) a/(sqrt(2) h) of the surfaces of drops: rigid for m << 1, mobile for
    m >> 1.

    Lambda is the drops' viscosity over the liquid's, a the contact size, h the gap; for round drops this is
    sqrt(R*/h)/lambda. [davis1989].

    >>> round(mobility(0.1, 0.01, 2.0) / math.sqrt(0.5), 12)
    5.0
    """
    return contact_size / (math.sqrt(2.0) * viscosity_ratio * gap)


def drop_factor(mobility: Number) -> Number:
    """Factor f(m) = (1 + 0.38 m)/(1 + 1.69 m + 0.43 m^2): squeeze friction of a film between drops over that between
    rigid spheres. [davis1989].

    >>> drop_factor(0.0)
    1.0
    """
    return (1.0 + 0.38 * mobility) / (1.0 + 1.69 * mobility + 0.43 * mobility**2)


def drop_power(mobility: Number) -> Number:
    """Slope d ln f/d ln m of `drop_factor`: from 0 to -1. [davis1989].

    >>> round(drop_power(1e9), 6)
    -1.0
    """
    over, under = 1.0 + 0.38 * mobility, 1.0 + 1.69 * mobility + 0.43 * mobility**2
    return 0.38 * mobility / over - (1.69 * mobility + 0.86 * mobility**2) / under


def drop_squeeze(
    contact_size: Length, gap: Length, viscosity: Viscosity, viscosity_ratio: Number, prefactor: Number
) -> Friction:
    """Squeeze friction of a film between drops: that of a rigid film times f(m), plus that of a freely slipping film,
    which alone remains between bubbles. [davis1989].

    >>> rigid = squeeze_friction(0.1, 0.01, 1.0, 4.0)
    >>> round(drop_squeeze(0.1, 0.01, 1.0, 1e9, 4.0) / rigid, 2), round(drop_squeeze(0.1, 0.01, 1.0, 1e-9, 4.0), 4)
    (1.02, 9.4248)
    """
    factor = drop_factor(mobility(contact_size, gap, viscosity_ratio))
    rigid = squeeze_friction(contact_size, gap, viscosity, prefactor)
    return factor * rigid + extension_friction(contact_size, gap, viscosity)


def drop_shear(
    contact_size: Length, gap: Length, viscosity: Viscosity, viscosity_ratio: Number, prefactor: Number
) -> Friction:
    """Shear friction eta a/(h/(c_t a) + 3/(8 lambda)) of a film between drops: film and drops deform in series.

    The shear friction of a drop is that of a disc of radius a that moves edgewise on its surface, 16/3 lambda eta a,
    half of that of a disc with liquid on both sides [happel1983].

    >>> round(drop_shear(0.1, 0.01, 1.0, 1e9, 3.0) / shear_friction(0.1, 0.01, 1.0, 3.0), 6)
    1.0
    """
    return viscosity * contact_size / (gap / (prefactor * contact_size) + 0.375 / viscosity_ratio)


class Resistance(NamedTuple):
    """Both frictions, and their exponents in the contact size a and the gap h."""

    squeeze: Friction
    shear: Friction
    squeeze_by_size: Number
    squeeze_by_gap: Number
    shear_by_size: Number
    shear_by_gap: Number
    shear_by_force: Number
    """exponent of the tangential force in the shear friction; 0 for a linear law"""
    shear_by_load: PerForce
    """d ln(shear friction) / d(compressive force)"""


def rigid_film(
    contact_size: Length,
    gap: Length,
    viscosity: Viscosity,
    viscosity_ratio: Number,
    film_prefactors: tuple[Number, Number],
) -> Resistance:
    """Film with no slip at both surfaces: solids, or surfaces covered with surfactant. [rognon2009,
    eq. 10 and 11].

    >>> rigid_film(0.1, 0.01, 1.0, 1.0, (1.0, 1.0)).squeeze_by_gap
    -3.0
    """
    squeeze = squeeze_friction(contact_size, gap, viscosity, film_prefactors[0])
    shear = shear_friction(contact_size, gap, viscosity, film_prefactors[1])
    return Resistance(squeeze, shear, 4.0, -3.0, 2.0, -1.0, 0.0, 0.0)


def half_mobile_film(
    contact_size: Length,
    gap: Length,
    viscosity: Viscosity,
    viscosity_ratio: Number,
    film_prefactors: tuple[Number, Number],
) -> Resistance:
    """Film with no slip at one surface and free slip at the other: a bubble against a solid. The flow is half of that
    in a film of twice the thickness, so that squeezing has a quarter of the friction, and shear has none.
    [batchelor1967].

    >>> rigid, half = (film(0.1, 0.01, 1.0, 1.0, (1.0, 1.0)).squeeze for film in (rigid_film, half_mobile_film))
    >>> round(half / rigid, 12)
    0.25
    """
    squeeze = 0.25 * squeeze_friction(contact_size, gap, viscosity, film_prefactors[0])
    shear = HARDLY * shear_friction(contact_size, gap, viscosity, film_prefactors[1])
    return Resistance(squeeze, shear, 4.0, -3.0, 2.0, -1.0, 0.0, 0.0)


def mobile_film(
    contact_size: Length,
    gap: Length,
    viscosity: Viscosity,
    viscosity_ratio: Number,
    film_prefactors: tuple[Number, Number],
) -> Resistance:
    """Film with free slip at both surfaces, of clean bubbles: `extension_friction`, without shear friction.
    [trouton1906].

    >>> round(mobile_film(0.1, 0.01, 1.0, 1.0, (1.0, 1.0)).squeeze / math.pi, 12)
    3.0
    """
    shear = HARDLY * shear_friction(contact_size, gap, viscosity, film_prefactors[1])
    squeeze = extension_friction(contact_size, gap, viscosity)
    return Resistance(squeeze, shear, 2.0, -1.0, 2.0, -1.0, 0.0, 0.0)


def drop_film(
    contact_size: Length,
    gap: Length,
    viscosity: Viscosity,
    viscosity_ratio: Number,
    film_prefactors: tuple[Number, Number],
) -> Resistance:
    """Film between clean drops, whose surfaces move with the liquid inside: `drop_squeeze`,
    `drop_shear`. [davis1989].

    >>> round(drop_film(0.1, 0.01, 1.0, 1e9, (1.0, 1.0)).shear_by_size, 6)
    2.0
    """
    m = mobility(contact_size, gap, viscosity_ratio)
    squeeze = drop_squeeze(contact_size, gap, viscosity, viscosity_ratio, film_prefactors[0])
    plug = extension_friction(contact_size, gap, viscosity) / squeeze
    power = (1.0 - plug) * drop_power(m)
    shear = drop_shear(contact_size, gap, viscosity, viscosity_ratio, film_prefactors[1])
    film = shear / shear_friction(contact_size, gap, viscosity, film_prefactors[1])
    by_size, by_gap = 4.0 - 2.0 * plug + power, -3.0 + 2.0 * plug - power
    return Resistance(squeeze, shear, by_size, by_gap, 1.0 + film, -film, 0.0, 0.0)


def elastohydrodynamic_film(
    contact_size: Length,
    gap: Length,
    viscosity: Viscosity,
    film_prefactors: tuple[Number, Number],
    compression: Force,
    slip_force: Force,
    body: Body,
    gap_weight: Number,
) -> Resistance:
    """Film that sliding entrains into compressed contacts: the tangential force is `entrained_force` plus a small
    Newtonian friction, T = sqrt(B u) + z u. The law has no squeeze friction; gaps relax by `extension_friction`.

    The speed follows from the force T: u = T/zeta with zeta = (sqrt(B) + sqrt(B + 4 z T))^2 / (4 T). B contains the
    part of the contact that is flattened by deflection, 1 - 2 R* c_h h / a^2, so that friction begins with compression.
    [seth2011].

    >>> film = elastohydrodynamic_film(0.1, 1e-9, 1.0, (1.0, 1e-12), 2.0, 0.5, Body(2.0, 1.0, 1.0), 1.0)
    >>> round(entrained_force(0.5 / film.shear, 2.0, 0.1, 1.0), 4), round(film.shear_by_force, 4)
    (0.5, -1.0)
    """
    squeeze = extension_friction(contact_size, gap, viscosity)
    slight = HARDLY * shear_friction(contact_size, gap, viscosity, film_prefactors[1])
    area, rest = contact_size * contact_size, 2.0 * body.reduced_radius * gap_weight * gap
    if compression <= 0.0 or area <= rest:
        return Resistance(squeeze, slight, 2.0, -1.0, 2.0, -1.0, 0.0, 0.0)
    flat = 1.0 - rest / area
    # The square root of B: the force at unit speed.
    lifted = entrained_force(1.0, compression, contact_size, viscosity) * math.sqrt(flat)
    quiet = QUIET * body.modulus * body.reduced_radius**2
    square = slip_force * slip_force
    size = math.sqrt(square + quiet * quiet)
    whole = math.sqrt(lifted * lifted + 4.0 * slight * size)
    both = lifted + whole
    newtonian = 4.0 * slight * size / (whole * both)
    entrained = 1.0 - newtonian
    by_rest = entrained * (1.0 / flat - 1.0)
    return Resistance(
        squeeze, both * both / (4.0 * size), 2.0, -1.0, 2.0 * newtonian + entrained + 2.0 * by_rest,
        -newtonian - by_rest, -entrained * square / (size * size), entrained / compression,
    )  # fmt: skip


INTERFACES: dict[str, Callable[..., Resistance]] = {
    "rigid": rigid_film,
    "half-mobile": half_mobile_film,
    "mobile": mobile_film,
    "drop": drop_film,
    "elastohydrodynamic": elastohydrodynamic_film,
}
"""The mobility of surfaces: `films.interface` of a scene. A row is the friction of a film as a function of contact
size, gap, prefactors, the compressive force, the tangential force on the film and the two bodies; further arguments are
constants of the scene, by their names in the `Contacts` of `ecume.models.soft`.
"""
