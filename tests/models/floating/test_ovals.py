"""The meniscus of an elliptic dish: its slope at the wall, a circle as an ellipse, and what is refused."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.flotation import Liquid
from ecume.laws.meniscus import Oval, oval_amplitudes, oval_tangents, wall_amplitude
from ecume.models import MODELS
from ecume.models.floating.dishes import AROUND, ellipse, field_of, wall_stiffness
from ecume.models.floating.forces.pair_forces import add_wall_forces
from ecume.models.liquids import liquid_of
from tests.models.floating.bowls import WATER, scene_of

FLOATING = MODELS["floating"]
LIQUID = Liquid(density=1000.0, surface_tension=0.0728, viscosity=1e-3)
PLACES = [(0.0, 0.0), (0.013, 0.002), (-0.004, 0.012), (0.001, -0.0139)]


def dish(keys):
    places = [list(place) for place in PLACES]
    body = f"[[particles]]\nradius = 1e-3\ndensity = 600.0\ncontact_angle = 1.2\npositions = {places}\n"
    return scene_of(f"{WATER}{body}[dish]\ncontact_angle = 0.7\n{keys}\n")


@pytest.mark.parametrize("size", [(0.03, 0.03), (0.04, 0.02), (0.09, 0.02), (0.006, 0.003), (1.0, 0.3)])
def test_the_sum_of_menisci_has_the_slope_of_the_wall_everywhere(size):
    """Between the points of the fit, too. Each meniscus solves the linear equation, and so does their sum."""
    amplitudes, length = oval_amplitudes(Oval(size), AROUND, 0.7, LIQUID), LIQUID.capillary_length
    edge, outward = oval_tangents(size, 2.0 * math.pi * (np.arange(512) + 0.37) / 512)
    touch, normal = oval_tangents(size, AROUND)
    away = np.sum(touch * normal, axis=1) - edge @ normal.T
    assert away.min() >= -1e-12
    slope = ((outward @ normal.T) * np.exp(-away / length)) @ amplitudes / length
    assert slope == pytest.approx(np.full(512, wall_amplitude(0.7, LIQUID) / length), rel=1e-2)
    at_centers = np.exp(-np.abs(ellipse(size).size) / length) @ np.abs(amplitudes)
    assert at_centers < 4.0 * wall_amplitude(0.7, LIQUID)  # no sum of large numbers that cancel


def test_a_circle_given_as_an_ellipse_has_the_forces_heights_and_stiffness_of_a_round_dish():
    forces, heights, stiffness = [], [], []
    for keys in ("radius = 0.016", 'shape = "ellipse"\nsize = [0.032, 0.032]'):
        scene = dish(keys)
        parameters = FLOATING.parameters(scene)
        found = np.zeros((len(PLACES), 2))
        add_wall_forces(parameters, np.array(PLACES), found)
        forces.append(found)
        x = np.linspace(-0.008, 0.008, 5)
        heights.append(field_of(scene.dish, liquid_of(scene), x, x))
        stiffness.append(wall_stiffness(parameters))
    assert forces[1] == pytest.approx(forces[0], rel=1e-6, abs=1e-8 * np.abs(forces[0]).max())
    assert heights[1] == pytest.approx(heights[0], rel=1e-6)
    assert 0.9 < stiffness[1] / stiffness[0] < 1.5


def test_a_light_float_at_the_wall_goes_to_the_ends_of_the_long_axis():
    """There the wall is nearest all around it, and the liquid highest."""
    scene = dish('shape = "ellipse"\nsize = [0.04, 0.02]')
    ends = field_of(scene.dish, liquid_of(scene), np.array([0.02, 0.0]), np.array([0.0, 0.01]))
    assert ends[0, 0] > 1.05 * ends[1, 1]


def test_multipoles_exact_menisci_and_straight_barriers_in_an_ellipse_are_refused():
    with pytest.raises(SceneError, match="multipole"):
        FLOATING.parameters(dish('shape = "ellipse"\nsize = [0.04, 0.03]\n[interaction]\nmethod = "multipole"'))
    with pytest.raises(SceneError, match="'profile', which is not known for this shape"):
        FLOATING.parameters(dish('shape = "ellipse"\nsize = [0.04, 0.03]\nlaw = "profile"'))
    with pytest.raises(SceneError, match="got an ellipse"):
        dish('shape = "ellipse"\nsize = [0.04, 0.03]\n[dish.barrier]\nvelocity = 0.001')
