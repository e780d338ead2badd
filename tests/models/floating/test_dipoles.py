"""Magnetic floats: menisci attract them, dipoles repel them."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from ecume.laws import capillarity, pair_laws
from ecume.models import MODELS
from ecume.models.floating.frames import observe
from ecume.models.floating.parameters import make_state
from ecume.models.floating.time_integration.integration import forces_at
from ecume.scenes.load import load_scene
from tests.models import begun
from tests.models.floating.bowls import HEAVY, LIGHT, WATER, scene_of

FLOATING = MODELS["floating"]
MOMENT = 1e-5


def magnets(positions, *, moments=(MOMENT, MOMENT), kinds=(HEAVY, HEAVY), rest="", **times):
    floats = "".join(
        f"[[particles]]\n{kind}magnetic_moment = {moment}\npositions = [{list(place)}]\n"
        for kind, moment, place in zip(kinds, moments, positions, strict=True)
    )
    return scene_of(WATER + floats + rest, **times)


def forces_of(scene):
    parameters, state, workspace = begun(scene)
    forces_at(parameters, state.position, workspace)
    return parameters, state, workspace


def both(distance, parameters, moments=(MOMENT, MOMENT)):
    """The force of menisci and dipoles; positive repels."""
    length, charge = parameters.pair[1], parameters.floats.charge
    strength = capillarity.pair_strength(0.0728, charge[0], charge[1])
    pushed = pair_laws.dipole_force(distance, pair_laws.dipole_strength(*moments))
    return capillarity.pair_force(distance, strength, length) + pushed


@pytest.mark.parametrize("moments", [(MOMENT, MOMENT), (MOMENT, -2e-5), (0.0, MOMENT)])
@pytest.mark.parametrize("distance", [2.2e-3, 5e-3, 2e-2])
def test_two_magnets_feel_both_laws_and_each_other_alike(moments, distance):
    parameters, _, workspace = forces_of(magnets([(0.0, 0.0), (distance, 0.0)], moments=moments, kinds=(HEAVY, LIGHT)))
    assert workspace.force[1, 0] == pytest.approx(both(distance, parameters, moments), rel=1e-6)
    assert np.abs(workspace.force.sum(axis=0)).max() < 1e-15 * np.abs(workspace.force).max()


def test_forces_are_the_slope_of_the_recorded_energy():
    places = [(0.0, 0.0), (4e-3, 1e-3), (1e-3, 5e-3)]
    scene = magnets(places, moments=3 * [MOMENT], kinds=(HEAVY, HEAVY, LIGHT))
    parameters, state, workspace = forces_of(scene)
    step, energies = 1e-7, []
    for moved in (-step, step):
        shifted = make_state(state.position + np.array([[moved, 0.0], [0.0, 0.0], [0.0, 0.0]]), state.velocity)
        frame = observe(parameters, shifted, FLOATING.workspace(parameters, shifted, 1.0))
        energies.append(frame.numbers["pair_energy"])
        assert frame.arrays["magnetic_moment"].tolist() == 3 * [MOMENT]
    assert workspace.force[0, 0] == pytest.approx((energies[0] - energies[1]) / (2 * step), rel=1e-5)


@pytest.mark.long
@pytest.mark.compiled
def test_two_magnets_come_to_rest_where_the_forces_cancel():
    motion = '[integration]\nintegrator = "overdamped"\n'
    scene = magnets([(-2.5e-3, 0.0), (2.5e-3, 0.0)], rest=motion, duration=1.0, frame_every=1.0)
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    root = brentq(both, 2.01e-3, 6e-3, args=(parameters,))
    assert both(0.9 * root, parameters) > 0.0 > both(1.1 * root, parameters)
    workspace = FLOATING.workspace(parameters, state, 1.0)
    assert FLOATING.advance(parameters, state, workspace, parameters.steps_per_frame) == 0
    assert np.ptp(state.position[:, 0]) == pytest.approx(root, rel=1e-6)


def test_dipoles_add_to_multipoles():
    places, rest = [(0.0, 0.0), (4e-3, 1e-3)], '[interaction]\nmethod = "multipole"\norder = 2\n'
    _, _, with_dipoles = forces_of(magnets(places, rest=rest))
    _, _, without = forces_of(magnets(places, moments=(0.0, 0.0), rest=rest))
    pushed = pair_laws.dipole_force(math.hypot(4e-3, 1e-3), pair_laws.dipole_strength(MOMENT, MOMENT))
    found = with_dipoles.force - without.force
    assert math.hypot(*found[1]) == pytest.approx(pushed, rel=1e-6)
    assert found[0] == pytest.approx(-found[1], rel=1e-9)


def test_moments_come_from_tables_too(tmp_path):
    (tmp_path / "magnets.csv").write_text("x [mm],y [mm],magnetic_moment [mA*m^2]\n0,0,0.02\n5,0,-0.02\n")
    (tmp_path / "scene.toml").write_text(
        f'model = "floating"\nduration = 1.0\nframe_every = 0.5\nparticles_from = "magnets.csv"\n[[particles]]\n{HEAVY}'
    )
    rows = load_scene(tmp_path / "scene.toml").rows
    assert [row.magnetic_moment for row in rows] == pytest.approx([2e-5, -2e-5])
