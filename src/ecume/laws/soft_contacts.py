"""The tables of tangential laws and of tension laws: the dependence of a contact's stiffness on its
deflection.

An elastic law (`ecume.laws.surfaces`) gives the stiffness k of a contact at one deflection. A deflection has a normal
part delta_n, positive in tension, and a part along the surface, delta_t. The tension law determines the normal
deflection that widens the contact, and the tension that its film transmits. The tangential law determines the effect of
the sheared part on the stiffness. Forces are k_n delta_n and k_t delta_t.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ecume.laws.soft_pair import Stiffness
from ecume.units import Area, Energy, Force, Length, Number, Pressure

DEFINITE = 4.9
"""The largest |delta_t| over |delta_n| at which the paper's tangential law has a definite stiffness, for a film that is
thin compared with the deflection: sqrt(24).
"""
DRAWN = 100.0
"""The factor of the tension above the cavitation limit in the force that opens the film."""
SOFTLY = 0.02
"""The range of the onset of cavitation, over the limit, in which the rate is differentiable."""


class Widening(NamedTuple):
    """The normal deflection that widens a contact."""

    deflection: Length
    follows: Number
    """its derivative by delta_n: 1 or 0"""


def symmetric_widening(stretch: Length) -> Widening:
    """Widening by a deflection of either sign: a^2 = 2 R* (c_h h + c_d |delta_n|). [rognon2009, eq.
    14].

    >>> symmetric_widening(0.1), symmetric_widening(-0.1)
    (Widening(deflection=0.1, follows=1.0), Widening(deflection=-0.1, follows=1.0))
    """
    return Widening(stretch, 1.0)


def gap_widening(stretch: Length) -> Widening:
    """Widening by compression alone; in tension a^2 = 2 R* c_h h, as between rigid spheres.

    Two spheres under tension do not flatten each other: the tension of the liquid acts where the gap is narrow
    [brenner1961]. Tension is k(h) delta_n, without a jump at delta_n = 0, where the slope of the force with respect to
    delta_n is the same from both sides if nothing shears the contact.

    >>> gap_widening(0.1), gap_widening(-0.1)
    (Widening(deflection=0.0, follows=0.0), Widening(deflection=-0.1, follows=1.0))
    """
    if stretch > 0.0:
        return Widening(0.0 * stretch, 0.0)
    return Widening(stretch, 1.0)


class Draw(NamedTuple):
    """The tension that opens a film, with cavitation."""

    tension: Force
    by_tension: Number
    """its derivative by the tension on the film"""
    by_size: Force
    """its derivative by ln(a)"""


def whole_draw(tension: Force) -> Draw:
    """Law of a film that transmits any tension.

    >>> whole_draw(0.3)
    Draw(tension=0.3, by_tension=1.0, by_size=0.0)
    """
    return Draw(tension, 1.0, 0.0 * tension)


def cavitation_limit(contact_size: Length, cavitation_pressure: Pressure) -> Force:
    """The largest tension of a film, pi a^2 p_c: its pressure is nowhere below the outer one by more than p_c.

    a is the contact size. p_c is the ambient pressure minus the vapor pressure, about 98 kPa for water at 20 degC; it
    is lower if the liquid contains nuclei or gas. [brennen1995].

    >>> round(cavitation_limit(0.1, 100.0), 9)
    3.141592654
    """
    return math.pi * contact_size**2 * cavitation_pressure


def cavitated_draw(tension: Force, contact_size: Length, cavitation_pressure: Pressure) -> Draw:
    """Law of a film with cavitation: under a tension F above the limit L it opens as under F + 100 (F - L), since vapor
    fills it.

    From L to 1.02 L the transition is smooth. Below L, and in compression, the result is F. [brennen1995].

    >>> cavitated_draw(1.0, 0.1, 100.0).tension, round(cavitated_draw(4.0, 0.1, 100.0).tension)
    (1.0, 87)
    """
    limit = cavitation_limit(contact_size, cavitation_pressure)
    over, width = tension - limit, SOFTLY * limit
    if over <= 0.0:
        return Draw(tension, 1.0, 0.0 * tension)
    part = min(over / width, 1.0)
    free = over * over / (2.0 * width) if over < width else over - 0.5 * width
    shift = 0.5 * part * part * SOFTLY if over < width else 0.5 * SOFTLY
    return Draw(tension + DRAWN * free, 1.0 + DRAWN * part, -2.0 * DRAWN * limit * (part + shift))


class Bending(NamedTuple):
    """The deflection at which the elastic law gives the stiffness, and its derivatives."""

    deflection: Length
    by_widening: Number
    by_shear: Number


def normal_bending(widening: Length, shear: Length) -> Bending:
    """The paper's law: the stiffness depends on the normal deflection alone, F_t = alpha_t E a(h, delta_n) delta_t.

    It has no potential: shearing a contact while it is wide, and releasing it while it is narrow, consumes energy; the
    opposite order releases energy. Its stiffness is not definite for |delta_t| > 4.9 |delta_n|. [rognon2009, eq. 12 to
    14]; [elata1996].

    >>> normal_bending(-0.1, 0.3)
    Bending(deflection=-0.1, by_widening=1.0, by_shear=0.0)
    """
    return Bending(widening, 1.0, 0.0)


def whole_bending(widening: Length, shear: Length, ratio: Number) -> Bending:
    """Law with a potential: the magnitude of the whole deflection, m = sqrt(delta_w^2 + r
    delta_t^2).

    delta_w is the normal deflection that widens the contact, r = k_t/k_n. Forces then derive from one potential,
    U(h, m) + k_n(h, 0) (delta_n^2 - delta_w^2)/2, which is convex: the stiffness is symmetric and definite, and at a
    constant gap no closed path of (delta_n, delta_t) creates energy, as [elata1996] require. To first order in
    delta_t it is the paper's law [rognon2009, eq. 12 to 14]; the difference is of the order (delta_t/delta_n)^2/4.

    >>> whole_bending(-0.3, 0.4, 1.0)
    Bending(deflection=0.5, by_widening=-0.6, by_shear=0.8)
    """
    size = math.sqrt(widening * widening + ratio * shear * shear)
    if size > 0.0:
        return Bending(size, widening / size, ratio * shear / size)
    return Bending(size, 1.0, 0.0)


def sheared_energy(stiffness: Stiffness, shear_squared: Area) -> Energy:
    """Energy k_t delta_t^2 / 2 of the paper's tangential force at its present stiffness.
    [rognon2009, eq. 12].

    >>> sheared_energy(2.0, 9.0)
    9.0
    """
    return 0.5 * stiffness * shear_squared


def no_sheared_energy(stiffness: Stiffness, shear_squared: Area) -> Energy:
    """Return zero: the energy of the whole deflection includes that of the shear.

    >>> no_sheared_energy(2.0, 9.0)
    0.0
    """
    return 0.0 * stiffness * shear_squared


@dataclass(frozen=True)
class TangentialLaw:
    """A row of the table: a tangential law and everything that depends on it.

    A law has no state other than the gap vector. Its formulas are compiled into the contacts.
    """

    bending: Callable[..., Bending]
    """the deflection at which the elastic law gives the stiffness, and its derivatives, from which the tangent follows;
    arguments are `widening`, `shear` and `ratio`, k_t/k_n
    """
    energy: Callable[..., Energy]
    """of the shear beside that of the bending (J), by the tangential stiffness and delta_t^2; while the stiffness
    changes, this energy changes without a force: `size_work`
    """
    papers: tuple[Callable[..., Any], ...]
    """functions whose docstrings name the references that `ecume cite` lists"""
    remark: str
    """its line in `ecume check`"""
    doubts: Callable[[Number], list[str]]
    """warnings of `ecume check`, from the total shear strain"""


@dataclass(frozen=True)
class TensionLaw:
    """A row of the table: a tension law and everything that depends on it. It has no state."""

    widening: Callable[..., Widening]
    """the deflection that widens the contact, from the normal one"""
    draw: Callable[..., Draw]
    """the tension that opens the film; arguments other than `tension` and `contact_size` are constants of the scene, by
    their names in the `Contacts` of `ecume.models.soft`
    """
    papers: tuple[Callable[..., Any], ...]
    remark: str
    doubts: Callable[[Number, Number], list[str]]
    """warnings of `ecume check`, from the total shear strain, and the cavitation pressure over the modulus"""
    needs: Mapping[str, str] = field(default_factory=dict)
    """options of the films that the law needs, and the message if one is missing"""


LITTLE_STRAIN = 0.3
"""The shear strain up to which neighbors remain neighbors."""
STRONG = 0.1
"""The cavitation pressure over the modulus above which surfaces deform beyond the range of the laws before a film
cavitates.
"""


def _indefinite(strain: Number) -> list[str]:
    said = (
        "films.tangential_law = 'secant' loses its definite stiffness where a tangential deflection exceeds 4.9 normal "
        "ones, which happens where neighbors change; use 'potential'"
    )
    return [said] if strain > LITTLE_STRAIN else []


def _bound(strain: Number, weakness: Number) -> list[str]:
    said = (
        "films.tension_law = 'symmetric' holds separating spheres together by a tension without bound; use 'gap', or "
        "'cavitation' where the liquid cavitates"
    )
    return [said] if strain > LITTLE_STRAIN else []


def _strong(strain: Number, weakness: Number) -> list[str]:
    said = (
        "the cavitation pressure is above a tenth of the modulus: films transmit tensions that stretch spheres beyond "
        "the range of the contact laws; use films.tension_law = 'gap'"
    )
    return [said] if strain > LITTLE_STRAIN and weakness > STRONG else []


def _no_doubts(*_: Number) -> list[str]:
    return []


TANGENTIAL = {
    "potential": TangentialLaw(
        whole_bending, no_sheared_energy, (whole_bending,),
        "forces derive from one potential of the whole deflection", _no_doubts,
    ),
    "secant": TangentialLaw(
        normal_bending, sheared_energy, (normal_bending,),
        f"F_t = alpha_t E a delta_t of the paper; definite up to |delta_t| = {DEFINITE:g} |delta_n|", _indefinite,
    ),
}  # fmt: skip
"""Tangential laws: `films.tangential_law` of a scene."""
TENSION = {
    "symmetric": TensionLaw(
        symmetric_widening, whole_draw, (symmetric_widening,),
        "contacts widen under tension as under compression, as in the paper", _bound,
    ),
    "gap": TensionLaw(
        gap_widening, whole_draw, (gap_widening,), "in tension the gap alone sets the contact size", _no_doubts
    ),
    "cavitation": TensionLaw(
        symmetric_widening, cavitated_draw, (symmetric_widening, cavitation_limit),
        "symmetric, up to a tension of pi a^2 x cavitation pressure", _strong,
        {"cavitation_pressure": "a film that cavitates has one; got none"},
    ),
}  # fmt: skip
"""Tension laws: `films.tension_law` of a scene."""
