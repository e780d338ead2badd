"""Properties of every law: its units, its papers, its examples, and equality of compiled and plain results."""

import doctest
import importlib
import inspect
import pkgutil
import re
import typing
from dataclasses import fields, is_dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pint
import pytest
from tests import oracles
from tests.oracles import dam_breaks, liquids, swirls
from tests.oracles import soft_contacts as soft_oracles

import ecume.laws
from ecume import _jit
from ecume.laws import (
    brownian_motion,
    capillarity,
    carrier_flows,
    contact_lines,
    density_diffusion,
    drag,
    drops,
    flotation,
    flows,
    friction,
    hydrostatics,
    interfaces,
    kernels,
    long_range,
    meniscus,
    moving_dish,
    permeability,
    ring_meniscus,
    soft_contacts,
    soft_pair,
    special,
    states,
    surfaces,
    tension,
    time_step_limits,
    unsteady_forces,
    viscous,
    wall_forces,
    water_waves,
    wave_makers,
)
from ecume.laws.surfaces import Body
from ecume.units import Unit

ROOT = Path(__file__).parents[2]
MODULES = sorted(
    module.name
    for package in (ecume.laws, oracles)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
)
COMPILED = (
    special,
    density_diffusion,
    brownian_motion,
    capillarity,
    friction,
    kernels,
    states,
    hydrostatics,
    moving_dish,
    viscous,
    tension,
    time_step_limits,
    soft_contacts,
    soft_pair,
    long_range,
    contact_lines,
    surfaces,
    interfaces,
    wall_forces,
    carrier_flows,
    unsteady_forces,
    permeability,
    ring_meniscus,
)
RESCALED = (
    carrier_flows, density_diffusion, brownian_motion, capillarity, friction, drag, meniscus, flotation.bodies,
    flotation.balance, flotation.equilibria, flotation.nonspherical, flotation.young_laplace, states, viscous, tension,
    time_step_limits, drops, flows, hydrostatics, long_range, moving_dish, soft_contacts, soft_pair, contact_lines,
    surfaces, interfaces, wall_forces, water_waves, wave_makers, dam_breaks, liquids, soft_oracles, swirls,
    unsteady_forces, permeability, ring_meniscus,
)  # fmt: skip
LIQUID = flotation.Liquid(density=3.0, surface_tension=0.7, viscosity=0.2, gravity=1.9, gas_density=0.4)
SAMPLES = {
    "distance": 0.83, "center_distance": 0.31, "r": 0.31, "dish_radius": 0.97, "width": 1.7, "position": (0.2, -0.3),
    "size": (1.7, 1.1), "capillary_length": 0.52, "strength": 0.37, "surface_tension": 0.61, "charge": 0.11,
    "charge_i": 0.13, "charge_j": -0.07, "wall_amplitude": 0.23, "radius": 0.21, "bond_number": 0.4, "wall_weight": 0.8,
    "density_ratio": 0.6, "contact_angle": 0.9, "filling_angle": 2.0, "slope_angle": 0.3, "cutoff": 3.0,
    "touching_distance": 0.4, "change": -0.3, "variance": 0.04, "exponential": 0.9,
    "mirrored": 0.03, "drift": -0.05, "draw": 0.7, "deviations": 1.3, "mean_free_path": 0.05,
    "accuracy": 1e-4, "approach_speed": 0.9, "mass": 0.8, "mass_i": 0.8, "mass_j": 1.7, "restitution": 0.4,
    "coefficient": 0.6, "viscosity": 0.3, "length": 1.3, "factor": 0.5, "friction": 0.2,
    "solid_gas": 0.3, "solid_liquid": 0.2,
    "liquid_gas": 0.5, "x": 1.7, "coefficients": (0.5, -1.5, 2.5), "liquid": LIQUID,
    "sphere": flotation.Sphere(0.21, 4.0, 1.2), "a": flotation.Sphere(0.21, 4.0, 1.2),
    "b": flotation.Sphere(0.17, 1.0, 0.7), "body": flotation.Sphere(0.21, 4.0, 1.2), "theory": "nonlinear",
    "bubble": flotation.Bubble(0.21), "disc": flotation.Disc(0.21, 0.1),
    "cylinder": flotation.VerticalCylinder(0.21, 0.3, 4.0, 1.2), "lying": flotation.HorizontalCylinder(0.21, 4.0, 1.2),
    "ellipsoid": flotation.Ellipsoid((0.21, 0.3, 0.15), 4.0, 1.2),
    "spheroid": flotation.nonspherical.Spheroid(0.3, 0.2, 1.2, 1.3),
    "q": 0.7, "density": 3.1, "reference_density": 3.0, "sound_speed": 11.0, "pressure": 2.7, "stiff": 50.0,
    "gravity": 1.9, "height": 0.3, "surface_height": 0.9, "depth": 0.6, "largest_speed": 0.4, "load": 1.7,
    "approach": -0.8, "distance_squared": 0.4, "smoothing_length": 0.6, "alpha": 0.1,
    "dimensions": 3.0, "viscosity_i": 0.3, "viscosity_j": 0.7, "volume_i": 0.02, "volume_j": 0.03, "strain_rate": 5.0,
    "spacing": 0.4, "strain_component": 1.3, "divergence": 0.2, "diagonal": 1.0, "excess": 0.3, "delta": 0.1,
    "tank": water_waves.Tank(1.7, 0.9, 1.9, 0.01), "excitation": water_waves.BaseExcitation(0.2, 1.1, 0.3),
    "lower": water_waves.Layer(3.1, 0.9), "upper": water_waves.Layer(1.2, 0.6),
    "slope": -2.5, "reach": 0.05, "density_i": 3.0, "density_j": 3.2, "rise_i": 0.05, "rise_j": 0.11, "potential": 0.7,
    "sound_speed_i": 11.5, "exponent": 7.0, "head": 0.01, "support": 1.1, "color_gradient": 3.0, "curvature": 0.9,
    "turning": -0.4, "spread": 0.6, "bend": 1.4, "contact_force": 0.9, "end_force": 0.3,
    "mode": 2.0, "speed": 0.8, "stokes_speed": 0.8, "inverse_viscosity": 1.6, "acceleration": 2.3,
    "wavenumber": 1.7, "time": 0.3, "dam_depth": 1.1, "downstream_depth": 0.2, "kinematic_viscosity": 0.01,
    "contact_size": 0.3, "gap": 0.02, "prefactor": 1.3, "radius_i": 0.4, "radius_j": 0.7, "modulus": 5.0,
    "modulus_i": 5.0, "modulus_j": 3.0, "reduced_radius": 0.25, "deflection": 0.01, "compression": 0.01,
    "gap_weight": 1.2, "deflection_weight": 0.6, "prefactors": soft_pair.Prefactors(), "steric_length": 0.05,
    "hamaker": 0.3, "layer_strength": 0.2, "debye_length": 0.04,
    "smallest_separation": 0.01, "force": 0.7, "gap_from": 0.01, "gap_to": 0.2,
    "separation": 2.7, "sign": 1.0, "reynolds": 30.0, "stokes_reynolds": 3.0, "sphericity": 0.8, "excess_density": 1.2,
    "temperature": 300.0, "thermal": 0.4, "weight": 0.6,
    "clearance": 0.05, "stiffness": 4.0, "ratio": 0.7, "deflection_from": 0.04, "deflection_to": 0.03,
    "phase_along": 0.4, "phase_across": 0.9, "phase_x": 0.4, "phase_y": 0.9, "speed_x": 0.8, "speed_y": 0.6,
    "wavenumber_x": 1.7, "wavenumber_y": 1.1, "across": 0.4, "along": 0.3, "upright": 0.2,
    "rate": 1.1, "pull_rate": 0.9,
    "stretching": 1.4, "here": 0.3, "there": 0.5, "rise": 0.1,
    "phase_next": 0.4, "phase_last": 0.9, "speed_squared": 0.5,
    "both": 0.4, "moment_i": 0.3, "moment_j": 0.2, "angle": 0.7, "elongation": 0.6, "rotation": 0.9, "shear": 1.1,
    "extension": -0.4,
    "area": 0.02, "film_area": 0.01, "facet_area": 0.03, "rest": 0.2, "radius_sum": 1.1, "mobility": 1.4,
    "viscosity_ratio": 2.3, "film_prefactors": (1.3, 0.7), "roughness": 0.03, "critical_load": 0.2,
    "pull": 1.5, "limit": 1.49,
    "pair": soft_pair.SoftPair(0.21, 9.0, 0.3), "areal_mass": 1.6, "overlap": 0.4, "plane_weight": 1.3,
    "bulk_viscosity": 0.7,
    "slip_force": 0.4,
    "color": 0.4, "cosine": 0.3, "gradient": 2.1, "least": 0.9, "pair_distance": 0.2, "surface_per_volume": 1.4,
    "trace": 1.7, "missing": 0.06, "completion": 1.3, "off": 1.3, "value": 0.3,
    "stretch": -0.02, "tension": 0.9, "cavitation_pressure": 3.1, "widening": -0.02,
    "shear_squared": 9e-4,
    "low": -0.2, "high": 0.5, "filled": 0.2, "solid_fraction": 0.6, "diameter": 0.4, "permeability": 1e-3, "room": 0.7,
    "place": (0.3, 0.2, 0.1), "stream": (0.4, 0.3, -0.2), "displaced": 0.3,
    "angular_frequency": 1.3, "frequency": 0.4, "peak": 0.35, "phase": 0.6,
    "directions": np.array([0.3, 1.7, 4.0]), "points": np.array([[0.3, 0.2], [-0.4, 0.1]]), "inclination": 0.2,
    "outward": np.array([[0.6, 0.8], [-1.0, 0.0]]), "tilt": meniscus.Tilt(0.3, 0.7), "first": 0.2, "second": -0.3,
    "oval": meniscus.Oval((1.7, 1.1), meniscus.Tilt(0.3, 0.7)), "radii": (0.97, 0.31), "contact_angles": (0.9, 1.3),
    "dim": 2, "swing": 0.2, "decay": 0.3, "damping": 0.4, "amplitude": 0.2, "velocity": 0.4, "slip": 0.7,
}  # fmt: skip
SAMPLES_OF_TYPES = {Body: Body(1.1, 0.25, 5.0)}
"""Of arguments whose name has another meaning elsewhere."""
ODD = {"[length]": 7.3, "[mass]": 0.31, "[time]": 1.9}
"""Base units that no law has heard of."""


BESIDE = {
    flotation.balance.round_load, flotation.balance.stable_load, flotation.balance.greatest_load,
    flotation.balance.slope_of_greatest, flotation.young_laplace.outer_meniscus, flotation.young_laplace.refined,
    special.fit_k1, special.k1_over_x, states.density_at_enthalpy, contact_lines.needle_charge,
    contact_lines.spread_charges, contact_lines.star_charges,
    surfaces.hertz_surface, surfaces.bubble_surface, surfaces.hertz_check_lines, surfaces.hertz_doubts,
    surfaces.bubble_check_lines, kernels.kernel,
}  # fmt: skip
"""Beside the laws: root finders, fits, sets of charges, and functions of a contact as a whole."""


def public(module):
    return {
        name: law for name, law in vars(module).items()
        if inspect.isfunction(law) and law.__module__ == module.__name__ and not name.startswith("_")
        and law not in BESIDE
    }  # fmt: skip


def arguments(law):
    """A sample for each argument without a default. A KeyError means that a new argument needs a sample."""
    wanted = [name for name, given in inspect.signature(law).parameters.items() if given.default is given.empty]
    hints = typing.get_type_hints(law)
    return {name: SAMPLES_OF_TYPES.get(hints[name]) or SAMPLES[name] for name in wanted}


REGISTRY = pint.UnitRegistry(cache_folder=None)


@cache
def scale(symbol):
    """The number of odd units in one SI unit."""
    dimensions = REGISTRY.Quantity(1.0, symbol).dimensionality
    return float(np.prod([ODD[name] ** float(power) for name, power in dimensions.items()]))


def rescaled(value, hint):
    """The same quantity in odd units."""
    if is_dataclass(value):
        hints = typing.get_type_hints(type(value), include_extras=True)
        return replace(value, **{f.name: rescaled(getattr(value, f.name), hints[f.name]) for f in fields(value)})
    if hasattr(hint, "_fields"):
        hints = typing.get_type_hints(hint, include_extras=True)
        return hint(*(rescaled(part, hints[name]) for name, part in zip(hint._fields, value, strict=True)))
    if typing.get_origin(hint) is tuple and isinstance(value, tuple) and Ellipsis not in typing.get_args(hint):
        return tuple(rescaled(v, h) for v, h in zip(value, typing.get_args(hint), strict=True))
    units = [extra for extra in getattr(hint, "__metadata__", ()) if isinstance(extra, Unit)]
    return value * scale(units[0].symbol) if units else value


PLAIN = {
    capillarity.truncation_radius, contact_lines.ellipsoid_friction, contact_lines.ellipsoid_turning_friction,
    soft_pair.crossover_gap, soft_pair.optimal_force, soft_pair.passage_time, soft_pair.reduced_force,
    soft_pair.size_under_force, soft_pair.steepness, soft_pair.surface_energy, soft_pair.surface_force,
    soft_pair.viscous_time, hydrostatics.absolute_pressure, hydrostatics.hydrostatic_fault,
    ring_meniscus.inner_wall_amplitude, ring_meniscus.ring_amplitudes, ring_meniscus.ring_height,
}  # fmt: skip
"""What compiled code does not call, or calls with the names of arguments."""
UNSCALED = {
    brownian_motion.thermal_energy,
    hydrostatics.absolute_pressure,
    hydrostatics.hydrostatic_fault,
    water_waves.viscous_decay,
    dam_breaks.stoker_bore,
}
"""Defaults in SI, words, or results of several units: they cannot be asked in other units."""
LAWS = [law for module in RESCALED for law in public(module).values() if law not in UNSCALED]
SWAY = (moving_dish.sway_place, moving_dish.sway_velocity, moving_dish.sway_acceleration, moving_dish.left_behind)
SCALARS = [*SWAY, *(law for module in COMPILED for law in public(module).values() if law not in PLAIN)]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{law.__module__.rsplit('.', 1)[-1]}.{law.__name__}")
def test_a_law_comes_out_in_the_unit_that_it_says(law):
    hints = typing.get_type_hints(law, include_extras=True)
    given = arguments(law)
    expected = rescaled(law(**given), hints["return"])
    found = law(**{name: rescaled(value, hints[name]) for name, value in given.items()})
    pairs = zip(numbers(found), numbers(expected), strict=True)
    assert all(a == pytest.approx(b, rel=1e-8, abs=1e-300) for a, b in pairs)


def numbers(result):
    """Every number in a result."""
    if is_dataclass(result):
        return [float(getattr(result, f.name)) for f in fields(result)]
    if isinstance(result, flotation.balance.Load):
        return [result.slope_angle, result.carried, result.change]
    return [float(value) for value in np.ravel(np.asarray(result, dtype=float))]


@pytest.mark.parametrize("law", LAWS + SCALARS, ids=lambda law: law.__name__)
def test_every_argument_and_result_of_a_law_says_its_unit(law):
    hints = typing.get_type_hints(law, include_extras=True)
    for name, hint in hints.items():
        plain = hint in (float, typing.Any) or hint is np.ndarray
        assert not plain, f"{law.__name__}: {name} is a plain number; annotate it with its unit"


@cache
def numba_ready():
    _jit.admit(*COMPILED, flows)


@pytest.mark.parametrize("law", SCALARS, ids=lambda law: law.__name__)
def test_a_compiled_law_gives_what_the_plain_one_gives(law):
    numba_ready()
    given = tuple(arguments(law).values())
    assert _jit.compiled(law)(*given) == pytest.approx(law(*given), rel=1e-14, abs=1e-300)


@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_a_law_are_true(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def bibliography():
    return set(
        re.findall(r"^@\w+\{(\w+),", (ROOT / "src/ecume/references.bib").read_text(encoding="utf-8"), re.MULTILINE)
    )


def cited(text):
    return {key for group in re.findall(r"\[([^\]]*)\]", text or "") for key in re.findall(r"\b[a-z]+\d{4}\b", group)}


@pytest.mark.parametrize("name", MODULES)
def test_every_paper_that_a_law_cites_is_in_the_bibliography(name):
    assert cited(inspect.getsource(importlib.import_module(name))) <= bibliography()


TABLES = {
    "walls": [law for row in capillarity.WALLS.values() for law in row],
    "pairs": [
        capillarity.pair_energy,
        capillarity.pair_force,
        capillarity.plane_wall_energy,
        capillarity.plane_wall_force,
    ],
    "charges": list(flotation.CHARGES.values()),
    "balances": list(flotation.BALANCES.values()),
    "kernels": [law for form in kernels.KERNELS.values() for law in (form.value, form.slope, *(form.line or ()))],
    "laminar": list(viscous.LAMINAR.values()),
    "excesses": list(density_diffusion.EXCESSES.values()),
    "quadrupoles": [
        contact_lines.quadrupole_strength,
        contact_lines.quadrupole_energy,
        contact_lines.quadrupole_force,
        contact_lines.quadrupole_torque,
    ],
    "remote": [law for row in long_range.REMOTE.values() for law in (row.energy, row.force, row.slope)],
    "interfaces": list(interfaces.INTERFACES.values()),
    "tangential": [law for row in soft_contacts.TANGENTIAL.values() for law in row.papers],
    "tension": [law for row in soft_contacts.TENSION.values() for law in row.papers],
}
UNCITED = {
    "no_wall_energy", "no_wall_force", "nonlinear_charge", "no_remote_energy", "no_remote_force", "no_remote_slope",
}  # fmt: skip
"""No physics of their own."""


@pytest.mark.parametrize("law", [law for table in TABLES.values() for law in table], ids=lambda law: law.__name__)
def test_a_law_of_a_table_names_its_paper(law):
    assert cited(law.__doc__) or law.__name__ in UNCITED
