"""The kinds of floats of a scene: equilibria, capillary charges, masses and drag."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ecume.engine.cells import Integers
from ecume.errors import BadInput, Fault, SceneError
from ecume.laws import drag, flotation, immersion
from ecume.laws.multipole.closures import righted
from ecume.models.floating.parameters import Floats
from ecume.models.floating.shaped.shapes import Figure, Given, floating_shape, round_figure
from ecume.models.liquids import liquid_of
from ecume.scenes.sizes import radii_of
from ecume.units import Array

if TYPE_CHECKING:
    from ecume.scenes.floating import DiscSpec, FloatingScene, FloatRow, FloatSpec, ShapeSpec


def turning_friction_of(kind: FloatKind, scene: FloatingScene) -> float:
    """The torque of the liquid on one float, per spin (N m s)."""
    liquid = liquid_of(scene)
    viscosity = liquid.viscosity_of_both if scene.hydrodynamics.resists else 0.0
    if isinstance(kind.body, flotation.Disc):
        return drag.disc_turning_friction(kind.body.radius, viscosity)
    depth = min(max(math.pi - kind.equilibrium.filling_angle, 0.0), math.pi)
    factor = float(immersion.turning_factor(depth, liquid.share_above))
    return drag.sphere_turning_friction(kind.radius, viscosity, factor)


def turning_frictions(scene: FloatingScene) -> Array:
    """The torque of the liquid per spin on each float (N m s)."""
    kinds, number = distinct_kinds(scene)
    return np.array([turning_friction_of(kind, scene) for kind in kinds])[number]


class FloatKind(NamedTuple):
    """One kind of float: its material and its equilibrium."""

    body: flotation.Body
    density: float
    contact_angle: float
    """NaN for a disc, whose edge pins the contact line at any angle"""
    equilibrium: flotation.Equilibrium
    charge: float
    mass: float
    friction: float
    rim: tuple[int, float] = (2, 0.0)
    """mode of an undulated rim, and its amplitude (m)"""
    figure: Any = None
    """a `Figure` in scenes where a float has a shape"""
    radius: float = 0.0
    """of the circumscribed circle"""
    righted: bool = False
    """whether the stability of a disc includes the moment of the horizontal tension"""


def contact_angle_of(given: FloatSpec | FloatRow, liquid: flotation.Liquid) -> float:
    """The contact angle: the given value, or from Young's law, or from the closure relation of the original project."""
    if given.surface_energies is not None:
        energies = given.surface_energies
        return flotation.young_contact_angle(
            solid_gas=energies.solid_gas, solid_liquid=energies.solid_liquid, liquid_gas=liquid.surface_tension
        )
    if isinstance(given.contact_angle, str):
        bare = flotation.Sphere(given.radius, given.density, 0.5 * math.pi)
        return flotation.closure_contact_angle(
            bond_number=flotation.bond_number(bare, liquid), density_ratio=flotation.density_ratio(bare, liquid)
        )
    assert given.contact_angle is not None  # noqa: S101  # the schema requires exactly one of the two
    return given.contact_angle


def float_kind(given: FloatSpec | FloatRow, scene: FloatingScene) -> FloatKind:
    """Return one kind of float. Raises BadInput if it sinks."""
    liquid = liquid_of(scene)
    if given.disc is not None:
        return disc_kind(given, given.disc, scene)
    if given.shape is not None:
        return shape_kind(given, given.shape, scene)
    sphere = flotation.Sphere(given.radius, given.density, contact_angle_of(given, liquid))
    balance = flotation.equilibrium(sphere, liquid)
    assert scene.interaction.charge is not None  # noqa: S101  # the scene has filled it in
    charge = flotation.capillary_charge(sphere, liquid, scene.interaction.charge)
    factor = float(immersion.factor_at_filling(balance.filling_angle, liquid.share_above))
    mass = given.density * 4.0 / 3.0 * math.pi * given.radius**3
    if scene.hydrodynamics.added_mass:
        mass += drag.added_mass(given.radius, balance.filling_angle, liquid.density, liquid.gas_density)
    friction = drag.stokes_friction(given.radius, liquid.viscosity_of_both, factor)
    found = FloatKind(sphere, given.density, sphere.contact_angle, balance, charge, mass, friction, radius=given.radius)
    return found._replace(figure=_round_figure(found, scene))


def disc_kind(given: FloatSpec | FloatRow, disc: DiscSpec, scene: FloatingScene) -> FloatKind:
    """Return a disc whose contact line is pinned to one of its edges. Raises BadInput if it sinks."""
    liquid = liquid_of(scene)
    solid = flotation.VerticalCylinder(given.radius, disc.thickness, given.density, 0.5 * math.pi)
    body = dataclasses.replace(flotation.disc_of_cylinder(solid, liquid, disc.rim), tilting=disc.tilting)
    body = righted(body, liquid) if disc.tension_moment else body
    balance = flotation.equilibrium(body, liquid)
    charge = flotation.capillary_charge(body, liquid, str(scene.interaction.charge))
    mass = given.density * math.pi * given.radius**2 * disc.thickness
    friction = drag.disc_friction(given.radius, liquid.viscosity_of_both)
    rim = disc.mode, disc.undulation
    found = FloatKind(body, given.density, math.nan, balance, charge, mass, friction, rim, radius=given.radius)
    return found._replace(figure=_round_figure(found, scene), righted=disc.tension_moment)


def shape_kind(given: FloatSpec | FloatRow, shape: ShapeSpec, scene: FloatingScene) -> FloatKind:
    """Return a float with a shape. Raises BadInput if it sinks."""
    liquid = liquid_of(scene)
    angle = math.nan if shape.pinned else contact_angle_of(given, liquid)
    asked = Given(shape, given.radius, given.density, angle, str(scene.interaction.charge))
    found = floating_shape(asked, liquid)
    figure = found.figure
    return FloatKind(
        body=found.body,
        density=given.density,
        contact_angle=angle,
        equilibrium=found.equilibrium,
        charge=figure.line.charge,
        mass=found.mass,
        friction=min(figure.friction[:2]),
        figure=figure,
        radius=given.radius,
    )


def _round_figure(kind: FloatKind, scene: FloatingScene) -> Figure | None:
    """The constants of a sphere or a disc in a scene with shapes; otherwise None."""
    if not scene.shaped or not isinstance(kind.body, flotation.Sphere | flotation.Disc):
        return None
    return round_figure(kind.body, kind.charge, kind.mass, kind.friction)


def float_kinds(scene: FloatingScene) -> list[FloatKind]:
    """The kind of each table and row of the scene. Raises SceneError with all faults."""
    faults: list[Fault] = []
    found: list[FloatKind] = []
    known: dict[Any, FloatKind | BadInput] = {}
    for where, given, _ in given_floats(scene):
        key = (given.radius, given.density, given.contact_angle, given.surface_energies, given.disc, given.shape)
        if key not in known:
            try:
                known[key] = float_kind(given, scene)
            except BadInput as error:
                known[key] = error
        kind = known[key]
        if isinstance(kind, BadInput):
            faults.append(Fault(where, str(kind)))
        else:
            found.append(kind)
    if faults:
        raise SceneError(faults)
    return found


def given_floats(scene: FloatingScene) -> list[tuple[str, FloatSpec | FloatRow, int]]:
    """The specifications of floats, each with its path and its number of equal floats. Tables of species come first,
    with one entry per float if sizes differ; rows follow.
    """
    found: list[tuple[str, FloatSpec | FloatRow, int]] = []
    for place, species in enumerate(scene.particles):
        path = f"particles[{place}]"
        if not species.sized:
            found.append((path, species, species.count))
            continue
        radius = radii_of(species, species.count, (scene.seed, place)).tolist()
        single = {one: _alone(species, one) for one in set(radius)}
        found += [(path, single[one], 1) for one in radius]
    return [*found, *((f"rows[{k}]", row, 1) for k, row in enumerate(scene.rows))]


def _alone(species: FloatSpec, radius: float) -> FloatSpec:
    """A species of a single float of this radius (m)."""
    return dataclasses.replace(
        species, radius=radius, count=1, positions=(), velocities=(), radii=(), sizes=None, volume_share=None
    )


def floats_of(scene: FloatingScene) -> Floats:
    """The properties of all floats: first the tables, then the rows."""
    kinds, entries = float_kinds(scene), given_floats(scene)
    counts = [count for _, _, count in entries]
    names = [kind.name for kind in scene.kinds]
    species = [names.index(given.species_name) for _, given, _ in entries]

    def each(of: Callable[[FloatKind], float]) -> Array:
        return np.repeat(np.array([of(kind) for kind in kinds]), counts)

    return Floats(
        radius=each(lambda kind: kind.radius),
        mass=each(lambda kind: kind.mass),
        charge=each(lambda kind: kind.charge),
        relaxation_time=each(lambda kind: drag.relaxation_time(kind.mass, kind.friction))
        if scene.hydrodynamics.resists
        else np.full(sum(counts), np.inf),
        density=each(lambda kind: kind.density),
        contact_angle=each(lambda kind: kind.contact_angle),
        species=np.repeat(np.array(species, dtype=np.int64), counts),
    )


def moments_of(scene: FloatingScene) -> Array:
    """The magnetic moments of all floats (A m^2)."""
    entries = given_floats(scene)
    moments = np.array([given.magnetic_moment for _, given, _ in entries])
    return np.repeat(moments, [count for _, _, count in entries])


def distinct_kinds(scene: FloatingScene) -> tuple[list[FloatKind], Integers]:
    """The distinct kinds of floats, and the number of the kind of each float."""
    found = float_kinds(scene)
    counts = [count for _, _, count in given_floats(scene)]
    number: dict[FloatKind, int] = {}
    for kind in found:
        number.setdefault(kind, len(number))
    return list(number), np.repeat(np.array([number[kind] for kind in found], dtype=np.int64), counts)
