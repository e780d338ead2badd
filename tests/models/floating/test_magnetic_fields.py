"""Induced and permanent moments in fields that oscillate: forces, energy, work, bits, and what is refused."""

import math

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.laws.pair_laws import PERMEABILITY, dipole_force, dipole_strength, induced_moment, oblique_dipole_energy
from ecume.models import MODELS
from ecume.models.floating.time_integration.integration import forces_at
from tests.models import begun
from tests.models.floating.bowls import WATER, scene_of

pytestmark = pytest.mark.uncompiled

FLOATING = MODELS["floating"]
RADIUS = 4e-4
ALONE = '[interaction]\nlaw = "none"\n'


def beads(places, field, *, moment=0.0, more=ALONE, **times):
    floats = (
        f"[[particles]]\nradius = {RADIUS}\ndensity = 2500.0\ncontact_angle = 1.2\nmagnetic_moment = {moment}\n"
        f"positions = {[list(place) for place in places]}\n"
    )
    return scene_of(f"{WATER}{floats}[magnetic_field]\nsusceptibility = 1e6\n{field}{more}", **times)


def potential(parameters, state, workspace, position):
    return FLOATING.observe(parameters, state._replace(position=position), workspace).numbers["pair_energy"]


@pytest.mark.parametrize(("field", "factor"), [((0, 0, 3e-3), 1.0), ((3e-3, 0, 0), -2.0), ((0, 3e-3, 0), 1.0)])
def test_beads_repel_across_the_field_and_attract_twice_as_strongly_along_it(field, factor):
    parameters, state, workspace = begun(beads([(0.0, 0.0), (2e-3, 0.0)], f"constant = {list(map(float, field))}\n"))
    moment = induced_moment(RADIUS, 1e6, 3e-3)
    assert moment == pytest.approx(4.0 * math.pi * RADIUS**3 * 3e-3 / PERMEABILITY, rel=1e-5)
    expected = factor * dipole_force(2e-3, dipole_strength(moment, moment))
    force = forces_at(parameters, state.position, workspace)
    assert force == pytest.approx(np.array([[-expected, 0.0], [expected, 0.0]]), rel=1e-9, abs=1e-9 * abs(expected))
    strength = dipole_strength(moment, moment)
    energy = oblique_dipole_energy(2e-3, strength, strength * (field[0] > 0.0))
    assert potential(parameters, state, workspace, state.position) == pytest.approx(energy)


def test_forces_in_any_field_are_minus_the_slope_of_the_energy():
    places = [(0.0, 0.0), (1.3e-3, 4e-4), (-5e-4, 1.5e-3)]
    field = "constant = [1e-3, -2e-3, 3e-3]\namplitude = [2e-3, 0.0, 1e-3]\nphase = [0.4, 0.0, 1.0]\n"
    parameters, state, workspace = begun(beads(places, field, moment=2e-7))
    force, step = forces_at(parameters, state.position, workspace).copy(), 1e-9
    slope = np.zeros_like(force)
    for i, axis in np.ndindex(force.shape):
        energies = []
        for way in (-step, step):
            position = state.position.copy()
            position[i, axis] += way
            energies.append(potential(parameters, state, workspace, position))
        slope[i, axis] = (energies[0] - energies[1]) / (2.0 * step)
    assert force == pytest.approx(slope, rel=1e-5, abs=1e-6 * np.abs(force).max())
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * np.abs(force).max()


def test_permanent_moments_repel_as_without_a_field():
    places = [(0.0, 0.0), (2e-3, 0.0)]
    parameters, state, workspace = begun(beads(places, "", moment=3e-7))
    expected = dipole_force(2e-3, dipole_strength(3e-7, 3e-7))
    assert forces_at(parameters, state.position, workspace)[1, 0] == pytest.approx(expected)


@pytest.mark.parametrize("integrator", ["velocity-verlet", "overdamped"])
def test_the_work_of_the_field_closes_the_energy_budget(integrator):
    """Energy gained and heat of drag are the injected work."""
    more = f'[integration]\nintegrator = "{integrator}"\n{ALONE}'
    field = "constant = [0.0, 0.0, 4e-3]\namplitude = [2e-3, 0.0, 0.0]\nfrequency = 100.0\nphase = [0.3, 0.0, 0.0]\n"
    scene = beads([(0.0, 0.0), (1.4e-3, 2e-4)], field, more=more, duration=0.5, frame_every=0.5)
    parameters, state, workspace = begun(scene)
    friction = parameters.floats.mass / parameters.floats.relaxation_time
    before, taken = FLOATING.observe(parameters, state, workspace).numbers["total_energy"], 0.0
    for _ in range(130):
        place = state.position.copy()
        assert FLOATING.advance(parameters, state, workspace, 1) == 0
        taken += float(np.sum(friction[:, None] * (state.position - place) ** 2)) / parameters.time_step
    numbers = FLOATING.observe(parameters, state, workspace).numbers
    gained = numbers["total_energy"] - before
    scale = abs(gained) + taken + abs(numbers["injected_work"])
    assert gained + taken - numbers["injected_work"] == pytest.approx(0.0, abs=0.02 * scale)
    assert abs(numbers["injected_work"]) > 0.3 * scale


def test_what_cannot_be_is_refused_with_the_reason():
    with pytest.raises(SceneError, match="fish"):
        FLOATING.parameters(beads([(0.0, 0.0)], 'species = ["fish"]\n'))
    with pytest.raises(SceneError, match="is known at the ends of a step"):
        FLOATING.parameters(beads([(0.0, 0.0)], "", more=f'[integration]\nintegrator = "rk4"\n{ALONE}'))
