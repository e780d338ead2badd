"""The cutoff of the pair law, for floats of any size."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import k1, k1e

from ecume.models import MODELS
from ecume.models.floating.forces.pair_forces import CAPILLARY_LENGTH
from tests.models.floating.bowls import WATER, scene_of
from tests.models.floating.test_forces import found_at

FLOATING = MODELS["floating"]
CAPILLARY = 2.724e-3
"""m, of the water in these scenes"""


def edge_force(distance):
    """exp(distance) times the integral of r K1(r) beyond the distance, by quadrature."""
    return quad(lambda r: r * k1e(r) * math.exp(distance - r), distance, distance + 60.0, epsabs=0, limit=200)[0]


def random_scene(seed, *, accuracy=None, rest=""):
    """One to three species of balls whose radii are random from 1e-4 to 30 capillary lengths."""
    rng = np.random.default_rng(seed)
    radii = CAPILLARY * 10.0 ** rng.uniform(-4.0, math.log10(30.0), rng.integers(1, 4))
    accuracy = accuracy if accuracy is not None else 10.0 ** rng.uniform(-8.0, -2.0)
    species, edge = "", 0.0
    for radius in radii.tolist():
        first, second = edge + radius, edge + 3.0 * radius
        species += f"[[particles]]\nradius = {radius!r}\ndensity = {rng.uniform(300.0, 800.0)!r}\n"
        species += f"contact_angle = {rng.uniform(0.9, 2.2)!r}\npositions = [[{first!r}, 0.0], [{second!r}, 0.0]]\n"
        edge += 4.0 * radius
    return scene_of(f"{WATER}{species}[interaction]\naccuracy = {accuracy!r}\n{rest}", duration=0.1, frame_every=0.1)


@pytest.mark.parametrize("seed", range(12))
def test_what_is_cut_off_is_below_the_accuracy_for_floats_of_any_size(seed):
    scene = random_scene(seed)
    parameters = FLOATING.parameters(scene)
    length, radius = float(parameters.pair[CAPILLARY_LENGTH]), parameters.floats.radius
    for one in np.unique(radius):
        for other in np.unique(radius):
            contact, cutoff = (one + other) / length, parameters.cutoff / length
            omitted = math.exp(contact - cutoff) * edge_force(cutoff) / edge_force(contact)
            assert omitted <= 1.0001 * scene.interaction.accuracy


@pytest.mark.parametrize("seed", range(12))
def test_touching_floats_of_any_size_attract_by_the_law(seed):
    parameters = FLOATING.parameters(random_scene(seed))
    length, radius, charge = (
        float(parameters.pair[CAPILLARY_LENGTH]),
        parameters.floats.radius,
        parameters.floats.charge,
    )
    for i in range(0, len(radius), 2):
        apart = 2.0 * radius[i] * (1.0 + 1e-9)
        places = np.cumsum(3.0 * radius) + 1e3 * parameters.cutoff * np.arange(len(radius))  # all others are far away
        places[i + 1 :] += places[i] + apart - places[i + 1]
        force = found_at(parameters, np.stack([places, np.zeros_like(places)], axis=1))[i, 0]
        expected = parameters.pair[0] * charge[i] * charge[i + 1] * k1(apart / length) / length
        assert force == pytest.approx(expected, rel=4e-6)
        assert force > 0.0
