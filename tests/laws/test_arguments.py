"""What the laws of floating bodies refuse, and what they take."""

import inspect
import itertools
import math

import numpy as np
import pytest

from ecume.errors import BadInput, FloaterSinks
from ecume.laws import flotation, multipole
from ecume.laws.arguments import CHECKS
from ecume.laws.multipole import solve

WATER = flotation.Liquid(1000.0, 0.0728, 1e-3)
BALL = flotation.Sphere(1e-3, 1300.0, 1.4)
STEEL = flotation.Sphere(2e-3, 7800.0, 1.4)
GOOD = {"bond_number": 0.5, "density_ratio": 0.4, "contact_angle": 1.3, "gap": 0.1, "excess": 0.05}
WILD = [0.0, -1.0, math.nan, math.inf, 90.0, 1e-300, 1e300, np.int64(1), 1, np.float32(0.5), "1", None, [], [0.1, 2.0]]
NUMBERS = [
    law
    for law in (getattr(flotation, name) for name in flotation.__all__)
    if inspect.isfunction(law) and set(inspect.signature(law).parameters) <= set(CHECKS)
]


@pytest.mark.parametrize("law", NUMBERS, ids=lambda law: law.__name__)
def test_whatever_a_law_of_pure_numbers_gets_it_answers_with_numbers_or_one_message(law):
    names = list(inspect.signature(law).parameters)
    for wild in itertools.product(WILD, repeat=len(names)):
        try:
            found = law(*wild)
        except BadInput:
            continue
        assert not np.isnan(np.asarray(found, dtype=np.float64)).any(), (wild, found)


@pytest.mark.parametrize("law", NUMBERS, ids=lambda law: law.__name__)
def test_a_law_of_pure_numbers_takes_arrays_and_whole_numbers(law):
    names = list(inspect.signature(law).parameters)
    given = [GOOD[name] for name in names]
    found = law(*(np.array([[value, value]]) for value in given))
    one = law(*given)
    for each, single in zip(np.atleast_3d(np.asarray(found)).reshape(-1, 1, 2), np.atleast_1d(one), strict=True):
        assert each == pytest.approx(single)
    if "bond_number" in names:
        whole = {**GOOD, "bond_number": np.int64(1), "density_ratio": np.float32(0.5)}
        if law is not flotation.closure_contact_angle:  # none is known for so large a sphere
            assert law(**{name: whole[name] for name in names}) == law(**{name: float(whole[name]) for name in names})


def test_degrees_are_recognized():
    with pytest.raises(BadInput, match="did you mean 80 degrees"):
        flotation.linear_charge(0.1, 1.2, 80.0)


@pytest.mark.parametrize("theory", flotation.CHARGES)
def test_no_theory_gives_a_force_for_spheres_that_sink(theory):
    with pytest.raises(FloaterSinks, match="sinks"):
        flotation.pair_force(STEEL, STEEL, 5e-3, WATER, theory)
    with pytest.raises(FloaterSinks, match="sinks"):
        flotation.capillary_charge(STEEL, WATER, theory)


def test_all_functions_have_the_same_default_theory():
    defaults = {
        parameter.default
        for name in flotation.__all__
        if inspect.isfunction(law := getattr(flotation, name))
        for parameter in inspect.signature(law).parameters.values()
        if parameter.name == "theory"
    }
    assert defaults == {"nonlinear"}


def test_lying_cylinders_attract_by_their_own_law_only():
    rod = flotation.HorizontalCylinder(1e-3, 1200.0, 1.5)
    for law in (flotation.pair_force, flotation.pair_energy):
        with pytest.raises(BadInput, match="lying_pair_force"):
            law(rod, rod, 5e-3, WATER)


def test_multipoles_refuse_bodies_that_sink_or_overlap():
    with pytest.raises(FloaterSinks):
        solve([[0.0, 0.0], [5e-3, 0.0]], [STEEL, STEEL], WATER)
    wetted = flotation.Sphere(1e-3, 900.0, 0.3)  # its contact line is far inside
    with pytest.raises(BadInput, match=r"bodies 0 and 1 overlap by 200 µm"):
        solve([[0.0, 0.0], [1.8e-3, 0.0]], [wetted, wetted], WATER)
    assert np.isfinite(solve([[0.0, 0.0], [2e-3, 0.0]], [wetted, wetted], WATER).forces).all()


def test_multipoles_take_numpy_integers_and_refuse_what_is_no_place():
    apart = [[0.0, 0.0], [3e-3, 0.0]]
    one, other = (solve(apart, [BALL, BALL], WATER, order).forces for order in (6, np.int64(6)))
    assert (one == other).all()
    for order in (6.0, "6", None, 0):
        with pytest.raises(BadInput, match="the order is"):
            solve(apart, [BALL, BALL], WATER, order)
    for places in ("here", [[0.0, 0.0], None], [[0.0, math.nan], [1.0, 0.0]]):
        with pytest.raises(BadInput, match="positions"):
            solve(places, [BALL, BALL], WATER)


@pytest.mark.parametrize("degrees", [10.0, 60.0, 100.0, 150.0])
def test_the_multipoles_of_a_cylinder_have_its_charge(degrees):
    """Far away the force is that of two charges, for a thin cylinder at any slope of the surface."""
    radius, length = 1e-6, WATER.capillary_length
    rod = flotation.VerticalCylinder(radius, 5e-3, 990.0, math.radians(degrees))
    charge = -radius * math.cos(math.radians(degrees))  # 2 pi gamma R sin(psi) over 2 pi gamma
    found = solve([[0.0, 0.0], [length, 0.0]], [rod, rod], WATER).forces[0, 0]
    expected = 2.0 * math.pi * WATER.surface_tension * charge**2 / length * 0.601907230197  # K1(1)
    assert found == pytest.approx(expected, rel=1e-4)
    assert multipole.closures.cylinder_closure(rod, WATER, 2).source[0].real != 0.0
