"""One contact as numbers: film and surface in series.

A contact's own state is the logarithm q of its gap and the direction n of its gap vector G = (R_i + R_j + h) n. Where
the spheres are says how far its surfaces are deflected: delta = X_j - X_i - G. The force of the deflection drives
the film, dG/dt = Z^-1 F. How it answers small changes stands in `links`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ecume._jit import admit, compiled_inside
from ecume.laws import bubbles, elasticity, friction, interfaces, long_range, lubrication
from ecume.laws.interfaces import Resistance
from ecume.models.soft.parameters import Contacts

admit(elasticity, lubrication, long_range, bubbles, interfaces, friction)

Body = tuple[float, float, float]
"""Of a pair: the sum of radii, the reduced radius and the modulus."""

FAINTEST = 1e-3
"""Of a film's friction where it has faded: the surfaces then relax at once, and nothing is left to jump."""


class Surface(NamedTuple):
    """How both surfaces of a contact give way at its present deflection."""

    size: float
    normal: float
    tangential: float
    """stiffnesses: force over deflection"""
    stiffening: float
    """d ln stiffness / d ln a"""
    size_by_gap: float
    """d ln a / d q at a deflection that is held"""
    size_by_stretch: float
    """d ln a / d delta_n"""


class Film(NamedTuple):
    """One contact as numbers."""

    gap: float
    reach: float
    """length of the gap vector"""
    pull: float
    """X_ij along n"""
    shear: float
    """and along the surface"""
    stretch: float
    """normal deflection"""
    surface: Surface
    resistance: Resistance
    faded: float
    """what part of its friction the film still has"""
    fade_slope: float
    """d ln(friction) / d q by fading"""
    remote_force: float
    remote_slope: float
    held: float
    """what of the tangential force the film bears, over that force: 1 without contact friction"""
    slide_by_pull: float
    slide_by_limit: float
    """slopes of what the film bears, over the tangential force and over the limit of contact friction"""
    limit_by_normal: float
    limit_by_gap: float
    """slopes of that limit, over the normal force and over q"""


@compiled_inside
def fading(gap: float, contacts: Contacts) -> tuple[float, float]:
    """What part of its friction a film still has, and the slope of its logarithm over ln(gap)."""
    if gap <= contacts.fade_from:
        return 1.0, 0.0
    u = min((gap - contacts.fade_from) / (contacts.fade_to - contacts.fade_from), 1.0)
    part = FAINTEST + (1.0 - FAINTEST) * (1.0 - u) ** 2 * (1.0 + 2.0 * u)
    slope = -(1.0 - FAINTEST) * 6.0 * u * (1.0 - u) / (contacts.fade_to - contacts.fade_from)
    return part, slope * gap / part


@compiled_inside
def remote_answer(gap: float, reduced_radius: float, contacts: Contacts) -> tuple[float, float]:
    """The remote force, positive repels, and its slope."""
    if contacts.remote == 1:
        given = (contacts.steric_strength, contacts.steric_length)
        return long_range.steric_force(gap, *given), long_range.steric_slope(gap, *given)
    if contacts.remote == 2:
        layer = (reduced_radius, contacts.hamaker, contacts.layer_strength, contacts.debye_length)
        return long_range.dlvo_force(gap, *layer), long_range.dlvo_slope(gap, *layer)
    return 0.0, 0.0


@compiled_inside
def surface_of(contacts: Contacts, body: Body, gap: float, stretch: float) -> Surface:
    """The surfaces by the scene's law: a place in the table `surfaces.SURFACES`."""
    radius_sum, reduced_radius, modulus = body
    # The kink of |delta| at zero is rounded off: a step across it would not converge.
    magnitude = math.sqrt(stretch * stretch + contacts.rounding * contacts.rounding)
    if contacts.surface == 1:
        rest = 2.0 * reduced_radius * contacts.gap_weight * gap
        area = rest + bubbles.flattened(magnitude, rest, radius_sum, reduced_radius)
        normal = bubbles.bubble_stiffness(area, radius_sum, reduced_radius, contacts.surface_tension)
        soft = bubbles.softness(area, radius_sum, reduced_radius)
        bend = bubbles.stiffening(area, radius_sum, reduced_radius)
        free = 2.0 * (area * soft - (area - rest) * bend)
        length = bubbles.flattening_length(radius_sum, reduced_radius)
        return Surface(
            size=math.sqrt(area),
            normal=normal,
            tangential=normal * contacts.tangential / contacts.normal,
            stiffening=2.0 * bend / soft,
            size_by_gap=rest * soft / free,
            size_by_stretch=length / free * stretch / magnitude,
        )
    size = elasticity.contact_size(reduced_radius, gap, magnitude, contacts.gap_weight, contacts.deflection_weight)
    per_size = reduced_radius / (size * size)
    return Surface(
        size=size,
        normal=elasticity.surface_stiffness(size, modulus, contacts.normal),
        tangential=elasticity.surface_stiffness(size, modulus, contacts.tangential),
        stiffening=1.0,
        size_by_gap=per_size * contacts.gap_weight * gap,
        size_by_stretch=per_size * contacts.deflection_weight * stretch / magnitude,
    )


@compiled_inside
def resistance_of(contacts: Contacts, size: float, gap: float) -> Resistance:
    """The film's friction by the scene's law: a place in the table `interfaces.INTERFACES`."""
    prefactors = (contacts.squeeze, contacts.shear)
    if contacts.interface == 1:
        return interfaces.half_mobile_film(size, gap, contacts.viscosity, contacts.viscosity_ratio, prefactors)
    if contacts.interface == 2:
        return interfaces.mobile_film(size, gap, contacts.viscosity, contacts.viscosity_ratio, prefactors)
    if contacts.interface == 3:
        return interfaces.drop_film(size, gap, contacts.viscosity, contacts.viscosity_ratio, prefactors)
    return interfaces.rigid_film(size, gap, contacts.viscosity, contacts.viscosity_ratio, prefactors)


@compiled_inside
def rubbing_of(contacts: Contacts, gap: float, normal: float, along: float) -> tuple[float, float, float, float, float]:
    """The last five numbers of a `Film`, by the scene's law: a place in `rubbing.FRICTIONS`."""
    if contacts.friction == 0 or normal >= 0.0 or gap >= contacts.roughness:
        return 1.0, 1.0, 0.0, 0.0, 0.0
    limit = friction.holding_force(-normal, gap, contacts.coefficient, contacts.roughness)
    pull = abs(along)
    slope = friction.sliding_slope(pull, limit)
    held = friction.sliding_force(pull, limit) / pull if pull > 0.0 else slope
    by_limit = friction.limit_slope(pull, limit) * (1.0 if along > 0.0 else -1.0)
    touching = friction.touching(gap, contacts.roughness)
    by_gap = -contacts.coefficient * normal * friction.touching_power(gap, contacts.roughness)
    return held, slope, by_limit, -contacts.coefficient * touching, by_gap


@compiled_inside
def film_of(contacts: Contacts, body: Body, log_gap: float, pull: float, shear: float) -> Film:
    """A contact's numbers."""
    gap = math.exp(log_gap)
    stretch = pull - body[0] - gap
    surface = surface_of(contacts, body, gap, stretch)
    faded, fade_slope = fading(gap, contacts)
    remote_force, remote_slope = remote_answer(gap, body[1], contacts)
    held, by_pull, by_limit, by_normal, by_gap = rubbing_of(
        contacts, gap, surface.normal * stretch, surface.tangential * shear
    )
    return Film(
        gap=gap,
        reach=body[0] + gap,
        pull=pull,
        shear=shear,
        stretch=stretch,
        surface=surface,
        resistance=resistance_of(contacts, surface.size, gap),
        faded=faded,
        fade_slope=fade_slope,
        remote_force=remote_force,
        remote_slope=remote_slope,
        held=held,
        slide_by_pull=by_pull,
        slide_by_limit=by_limit,
        limit_by_normal=by_normal,
        limit_by_gap=by_gap,
    )
