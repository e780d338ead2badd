"""The table of pair laws: the forces between two floats, one of which a scene chooses
(`interaction.law`).

A row of the table holds everything that depends on the choice. Its functions take and return plain numbers, so that
they can be compiled into a simulation. `own` contains the properties of the two floats, and `law` the constants of the
law, a NamedTuple of plain numbers. Compiled code selects the law by its type: each formula has a separate type. Forces
are positive when they repel.

Magnets that stand upright in a liquid surface repel each other over millimeters, beyond the range of menisci. An
electric dipole p in the gas acts as a moment c p, with c the speed of light.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from typing import Annotated, Any, NamedTuple, get_args, get_type_hints

from ecume._tables import by_constants
from ecume.laws.capillarity import one_sided_legacy_force, pair_energy, pair_force, pair_strength
from ecume.laws.ewald import SplitFit, fitted_short_pull
from ecume.laws.special import DEGREE, ScreenedFit, bessel_k0, bessel_k1, fit_k1, k1_over_x
from ecume.units import Area, Energy, Force, Length, Number, SurfaceTension, Unit

Moment = Annotated[float, Unit("A*m^2")]
DipoleStrength = Annotated[float, Unit("J*m^3")]
FluxDensity = Annotated[float, Unit("T")]

PERMEABILITY = 1.25663706127e-6
"""N/A^2, of the vacuum; liquids that are not magnetic change it by 1e-5."""


def dipole_strength(moment_i: Moment, moment_j: Moment) -> DipoleStrength:
    """Strength mu_0 m_i m_j / (4 pi) of two moments m along the vertical: positive (repulsive) for equal directions.
    [jackson1999, par. 5.7].

    >>> round(dipole_strength(1.0, -1.0) * 1e7, 6)
    -1.0
    """
    return PERMEABILITY * moment_i * moment_j / (4.0 * math.pi)


def dipole_energy(distance: Length, strength: DipoleStrength) -> Energy:
    """Energy of two moments perpendicular to their plane, zero when far apart: E = C / l^3, C the
    `dipole_strength`.

    For magnets much smaller than their distance, or homogeneous spheres at any distance. [jackson1999, par. 5.7].

    >>> dipole_energy(2.0, 4.0)
    0.5
    """
    return strength / distance**3


def dipole_force(distance: Length, strength: DipoleStrength) -> Force:
    """Force between two such moments along the line of centers; positive repels: F = 3 C / l^4. [jackson1999, par.
    5.7].

    >>> dipole_force(2.0, 16.0)
    3.0
    """
    return 3.0 * strength / distance**4


def oblique_dipole_energy(distance: Length, product: DipoleStrength, along: DipoleStrength) -> Energy:
    """Energy of two moments of any directions: E = (P - 3 A)/l^3 with P = mu_0 m_i.m_j/(4 pi) and A = mu_0
    (m_i.n)(m_j.n)/(4 pi), where n is the direction from one to the other. [jackson1999, par. 5.7].

    Along the line of centers two moments attract twice as strongly as they repel across it.

    >>> oblique_dipole_energy(1.0, 1.0, 0.0), oblique_dipole_energy(1.0, 1.0, 1.0)
    (1.0, -2.0)
    """
    return (product - 3.0 * along) / distance**3


def induced_moment(radius: Length, susceptibility: Number, field: FluxDensity) -> Moment:
    """Moment of a sphere in a field: m = V chi_e B/mu_0, chi_e = 3 chi/(3 + chi), with the demagnetizing factor 1/3 of
    a sphere; chi_e is at most 3, for soft iron. [jackson1999, par. 5.11].

    >>> round(induced_moment(1e-3, 1e9, 1e-3) * 1e6, 3)
    10.0
    """
    volume = 4.0 / 3.0 * math.pi * radius**3
    return volume * 3.0 * susceptibility / (3.0 + susceptibility) * field / PERMEABILITY


def neglected_dipoles(cutoff: Number) -> Number:
    """Fraction of the force at the edge of a half-plane of magnets that pairs beyond the cutoff
    contribute: 1/c^2.

    The cutoff is over the touching distance: int_c^inf r^-4 r dr over the integral from one on. [jackson1999, par.
    5.7].

    >>> neglected_dipoles(10.0)
    0.01
    """
    return 1.0 / (cutoff * cutoff)


Stiffness = Annotated[float, Unit("N/m")]
InverseArea = Annotated[float, Unit("1/m^2")]


class PairParameters(NamedTuple):
    """The properties of the two floats of a pair that a pair law receives, in addition to the distance of their
    centers.
    """

    radius_i: Length
    radius_j: Length
    charge_i: Length
    charge_j: Length
    capillary_length: Length
    surface_tension: SurfaceTension


class Setting(NamedTuple):
    """The liquid and the range of distances for which a law computes its constants."""

    capillary_length: Length
    surface_tension: SurfaceTension
    closest: Length
    """the shortest distance between two centers at which the law must be accurate"""
    farthest: Length
    """the longest such distance"""


class PairLaw(NamedTuple):
    """A row of the table: a pair law and everything that depends on it."""

    constants: type
    """the type of `law`: a NamedTuple of plain numbers that no other formula uses"""
    make_constants: Callable[..., Any]
    """make_constants(setting, ...): the constants, an instance of `constants`. Further arguments, with units and
    defaults, are the numbers that a scene may set in `interaction.constants`. Raises BadInput
    """
    force: Callable[[float, PairParameters, Any], float]
    """force(distance, own, law) between the two floats (N), positive when it repels; if the law is not reciprocal, the
    force on float i
    """
    energy: Callable[[float, PairParameters, Any], float] | None
    """energy(distance, own, law) (J), whose derivative is minus the force; None if the law has no potential"""
    papers: tuple[Callable[..., Any], ...]
    """functions whose docstrings name the references that `ecume cite` lists"""
    pull: Callable[[float, PairParameters, Any], float] | None = None
    """pull(square, own, law) = -force/distance (N/m) from the square of the distance, in the form that is fast in the
    loop over pairs: without branches and library calls the loop vectorizes. Default: computed from `force`
    """
    stiffness: Callable[[float, PairParameters, Any], float] | None = None
    """stiffness(distance, own, law) = |dF/dl| (N/m), which limits the time step. Default: finite differences"""
    raft_pull: Callable[[Any, Any, float, Any], Any] | None = None
    """raft_pull(charge, area, capillary_length, law): the force (N) on each float at the edge of a raft of all floats
    that covers this area (m^2), which limits the time step without inertia. Default: the integral over a half-plane
    """
    bond: str = "pair bond"
    """the name that `ecume check` gives to the energy of two touching floats in units of kT"""
    check_lines: Callable[[Any], list[tuple[str, str, str]]] | None = None
    """check_lines(law): additional lines of `ecume check` (name, value with unit, remark)"""
    needs_radii: bool = True
    """whether the force depends on the radii; gathering them takes time"""
    threaded: bool = True
    """whether several threads may compute the sum over pairs"""
    reciprocal: bool = True
    """whether the forces on the two floats are equal and opposite"""
    menisci: bool = False
    """whether the law is the superposition of menisci, which multipoles, corrected pairs, grids and shapes refine"""
    has_force: bool = True
    """whether the force can differ from zero"""


class Capillary(NamedTuple):
    """Constants of the capillary law. The fit of K1 is stored flat since threads do not accept nested tuples."""

    strength: SurfaceTension
    """2 pi gamma"""
    inverse_square: InverseArea
    """of the capillary length"""
    lower: Number
    shift: Number
    slope: Number
    offset: Number
    origin: Number
    w0: Number
    w1: Number
    w2: Number
    w3: Number
    w4: Number
    w5: Number
    w6: Number
    w7: Number
    w8: Number
    w9: Number
    w10: Number
    w11: Number
    w12: Number
    w13: Number
    w14: Number
    w15: Number
    w16: Number


def capillary_constants(setting: Setting) -> Capillary:
    """The constants of the capillary law."""
    return _capillary(pair_strength(setting.surface_tension, 1.0, 1.0), setting)


def no_constants(setting: Setting) -> Capillary:
    """The constants of the capillary law with zero strength."""
    return _capillary(0.0, setting)


def _capillary(strength: float, setting: Setting) -> Capillary:
    length = setting.capillary_length
    fit = fit_k1(setting.closest / length, setting.farthest / length)
    assert len(fit.weights) == DEGREE + 1  # noqa: S101  # as many as there are fields
    return Capillary(strength, length**-2, fit.lower, fit.shift, fit.slope, fit.offset, fit.origin, *fit.weights)


def capillary_force(distance: Length, own: PairParameters, law: Capillary) -> Force:
    """The capillary force between two floats: `capillarity.pair_force`. [nicolson1949, canbraun2022]."""
    return pair_force(distance, law.strength * (own.charge_i * own.charge_j), own.capillary_length)


def capillary_energy(distance: Length, own: PairParameters, law: Capillary) -> Energy:
    """The capillary energy of two floats: `capillarity.pair_energy`. [nicolson1949, canbraun2022]."""
    return pair_energy(distance, law.strength * own.charge_i * own.charge_j, own.capillary_length)


def capillary_pull(square: Area, own: PairParameters, law: Capillary) -> Stiffness:
    """The capillary attraction divided by the distance, from the fit of K1. It is symmetric in i and j to the last bit,
    so that the forces cancel exactly. [nicolson1949].
    """
    weights = (
        law.w0, law.w1, law.w2, law.w3, law.w4, law.w5, law.w6, law.w7, law.w8, law.w9, law.w10, law.w11, law.w12,
        law.w13, law.w14, law.w15, law.w16,
    )  # fmt: skip
    fit = ScreenedFit(law.lower, law.lower, law.shift, law.slope, law.offset, law.origin, weights, law.lower)
    scale = law.strength * law.inverse_square
    return scale * (own.charge_i * own.charge_j) * k1_over_x(square * law.inverse_square, fit)


def capillary_stiffness(distance: Length, own: PairParameters, law: Capillary) -> Stiffness:
    """The stiffness |dF/dl| = (S/L^2) (K0(x) + K1(x)/x) at the distance x L. [nicolson1949]."""
    x = distance / own.capillary_length
    strength = abs(law.strength * (own.charge_i * own.charge_j))
    return strength / own.capillary_length**2 * (bessel_k0(x) + bessel_k1(x) / x)


def capillary_raft_pull(charge: Any, area: Area, capillary_length: Length, law: Capillary) -> Any:
    """The force F = pi S A n min(L, r) on a float of charge A at the edge of a raft, where n is the raft's charge per
    area and r its radius: the attraction of a half-plane, or of the whole raft if it were at its center.
    """
    attraction = math.pi * float(charge.sum()) / area * min(capillary_length, math.sqrt(area / math.pi))
    return abs(law.strength) * charge * attraction


class OneSided(NamedTuple):
    """Constants of the pair law of the original program."""

    strength: SurfaceTension


def one_sided_constants(setting: Setting) -> OneSided:
    """The constants of the pair law of the original program."""
    return OneSided(pair_strength(setting.surface_tension, 1.0, 1.0))


def one_sided_force(distance: Length, own: PairParameters, law: OneSided) -> Force:
    """The force on float i, which depends on the charge of float j alone: `capillarity.one_sided_legacy_force`.
    [canbraun2022, eq. 21].
    """
    strength = pair_strength(own.surface_tension, own.charge_j, own.charge_j)
    return one_sided_legacy_force(distance, strength, own.capillary_length, own.radius_i + own.radius_j)


def one_sided_stiffness(distance: Length, own: PairParameters, law: OneSided) -> Stiffness:
    """The stiffness of the capillary law between two floats with the larger of the charges."""
    x, charge = distance / own.capillary_length, max(abs(own.charge_i), abs(own.charge_j))
    return law.strength * charge * charge / own.capillary_length**2 * (bessel_k0(x) + bessel_k1(x) / x)


class Dipoles(NamedTuple):
    """Constants of the force between upright dipoles, whose moments replace the charges."""

    strength: DipoleStrength
    """of two unit moments"""


def dipoles_force(distance: Length, own: PairParameters, law: Dipoles) -> Force:
    """The force between two moments: `dipole_force`. [jackson1999, par. 5.7]."""
    return dipole_force(distance, law.strength * own.charge_i * own.charge_j)


def dipoles_energy(distance: Length, own: PairParameters, law: Dipoles) -> Energy:
    """The energy of two moments: `dipole_energy`. [jackson1999, par. 5.7]."""
    return dipole_energy(distance, law.strength * own.charge_i * own.charge_j)


def dipoles_pull(square: Area, own: PairParameters, law: Dipoles) -> Stiffness:
    """The force between two moments divided by minus the distance. [jackson1999, par. 5.7]."""
    return -3.0 * law.strength * (own.charge_i * own.charge_j) / (square * square * math.sqrt(square))


class Short(NamedTuple):
    """Constants of the short-range part of the capillary law, used when a grid sums the long-range part."""

    strength: SurfaceTension
    inverse_square: InverseArea
    lower: Number
    upper: Number
    sharpness: Number
    shift: Number
    slope: Number
    offset: Number
    w0: Number
    w1: Number
    w2: Number
    w3: Number
    w4: Number
    w5: Number
    w6: Number
    w7: Number
    w8: Number
    w9: Number
    w10: Number


def short_constants(strength: SurfaceTension, capillary_length: Length, fit: SplitFit) -> Short:
    """The constants of the short-range part."""
    found = fit.lower, fit.upper, fit.sharpness, fit.shift, fit.slope, fit.offset
    return Short(strength, capillary_length**-2, *found, *fit.weights)


def short_pull(square: Area, own: PairParameters, law: Short) -> Stiffness:
    """The attraction of the short-range part divided by the distance."""
    weights = law.w0, law.w1, law.w2, law.w3, law.w4, law.w5, law.w6, law.w7, law.w8, law.w9, law.w10
    numbers = law.lower, law.upper, law.sharpness, law.shift, law.slope, law.offset
    fit = SplitFit(*numbers, weights, law.lower)
    scale = law.strength * law.inverse_square
    return scale * (own.charge_i * own.charge_j) * fitted_short_pull(square * law.inverse_square, fit)


def short_force(distance: Length, own: PairParameters, law: Short) -> Force:
    """The force of the short-range part."""
    return -short_pull(distance * distance, own, law) * distance


CAPILLARY = PairLaw(
    Capillary,
    capillary_constants,
    capillary_force,
    capillary_energy,
    papers=(pair_energy, pair_force),
    pull=capillary_pull,
    stiffness=capillary_stiffness,
    raft_pull=capillary_raft_pull,
    bond="capillary bond",
    needs_radii=False,
    menisci=True,
)
PAIR_LAWS = {
    "none": CAPILLARY._replace(make_constants=no_constants, papers=(), menisci=False, has_force=False),
    "capillary": CAPILLARY,
    "one-sided-legacy": PairLaw(
        OneSided,
        one_sided_constants,
        one_sided_force,
        energy=None,
        papers=(one_sided_legacy_force, pair_force),
        stiffness=one_sided_stiffness,
        reciprocal=False,
    ),
}
"""The choices of `interaction.law`. To add a law, add a row: see docs/extend/pair-law.md."""
INTERNAL = (
    PairLaw(Dipoles, lambda setting: None, dipoles_force, dipoles_energy, (), dipoles_pull, needs_radii=False),
    PairLaw(Short, lambda setting: None, short_force, None, (), short_pull, needs_radii=False),
)
"""Laws that belong to other options (magnets, grids) and use the same loop over pairs."""
CAPABILITIES = {
    "reciprocal": "exerts equal and opposite forces on the two floats",
    "menisci": "is the superposition of menisci",
}
"""The properties that an option can require of a pair law, as texts."""


def row_of(constants: type) -> PairLaw:
    """The row whose constants have this type. Raises LookupError for other types."""
    row = _BY_CONSTANTS.get(constants)
    if row is None:
        raise LookupError(f"no pair law has constants of the type {constants.__name__}")
    return row


def settable(row: PairLaw) -> dict[str, str]:
    """The numbers that a scene may set in `interaction.constants`, in order, with their units."""
    hints = get_type_hints(row.make_constants, include_extras=True)
    names = list(inspect.signature(row.make_constants).parameters)[1:]
    return {name: next(mark.symbol for mark in get_args(hints[name]) if isinstance(mark, Unit)) for name in names}


def described(row: PairLaw, given: Sequence[float]) -> str:
    """The numbers that a scene may set, with units: the given values, and the defaults of the others."""
    usual = [each.default for each in list(inspect.signature(row.make_constants).parameters.values())[1:]]
    values = [*given, *usual[len(given) :]]
    known = settable(row).items()
    return ", ".join(f"{name} = {value:g} {unit}" for (name, unit), value in zip(known, values, strict=True))


def add_row(row: PairLaw) -> None:
    """Register a row for the lifetime of this process, so that compiled code finds it."""
    _BY_CONSTANTS[row.constants] = row


OF_THE_CHOICE = frozenset({"make_constants", "papers", "menisci", "has_force"})
"""Fields that are read from the row that a scene chooses: rows with constants of one type may differ in them."""

_BY_CONSTANTS = by_constants((*INTERNAL, *PAIR_LAWS.values()), OF_THE_CHOICE)
