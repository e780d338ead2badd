"""Accepted and refused arguments of the laws of floating bodies."""

import inspect
import itertools
import math

import numpy as np
import pytest

from ecume.errors import BadInput, FloaterSinks
from ecume.laws import flotation
from ecume.laws.arguments import CHECKS

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


@pytest.mark.long
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
