"""Sums with a grid, compared with direct ones."""

import numpy as np
import pytest
from scipy.special import k0, k1

from ecume import _jit
from ecume.errors import SceneError
from ecume.models import MODELS
from ecume.models.floating.forces import ewald_grid
from ecume.models.floating.frames import observe
from ecume.models.floating.parameters import part_of
from ecume.models.floating.time_integration.integration import forces_at
from tests.models import begun
from tests.models.floating.bowls import WATER, scene_of

FLOATING = MODELS["floating"]
SMALL = "radius = 3e-5\ncontact_angle = 1.5707963\n"
SLOW = '[integration]\nintegrator = "overdamped"\n'


def scene_of_beads(count, *, interaction='summation = "grid"', motion=SLOW, dish="", **times):
    """Equal numbers of heavy and light floats, with opposite charges."""
    floats = f'[[particles]]\nname = "heavy"\ncount = {count // 2}\ndensity = 2000.0\n{SMALL}'
    floats += f'[[particles]]\nname = "light"\ncount = {count - count // 2}\ndensity = 1.0\n{SMALL}'
    return scene_of(f"{WATER}{floats}{motion}[interaction]\n{interaction}\n{dish}", **times)


def grid_forces(parameters, state, workspace):
    return forces_at(parameters, state.position, workspace).copy()


def direct(parameters, position):
    """Forces and energy of all pairs."""
    length, strength, charge = parameters.pair[1], parameters.pair[0], parameters.floats.charge
    apart = position[None] - position[:, None]
    distance = np.hypot(apart[..., 0], apart[..., 1]) / length
    np.fill_diagonal(distance, np.inf)
    product = strength * charge[:, None] * charge[None]
    pull = product * k1(distance) / distance / length**2
    return np.einsum("ij,ijk->ik", pull, apart), -0.5 * np.sum(product * k0(distance))


@pytest.mark.parametrize("accuracy", [1e-2, 1e-4, pytest.param(1e-6, marks=[pytest.mark.long, pytest.mark.compiled])])
@pytest.mark.parametrize("side", ["0.006", "0.06"])
def test_forces_are_the_direct_sum_to_the_accuracy_asked_for(accuracy, side):
    """In a dish of two capillary lengths copies are kept away by a cut, in one of twenty by distance."""
    dish = f'[dish]\nsize = [{side}, {side}]\nlaw = "none"\n'
    if side == "0.06" and accuracy < 1e-4:
        pytest.skip("the same grid, only larger")
    scene = scene_of_beads(160, interaction=f'summation = "grid"\naccuracy = {accuracy}', dish=dish)
    parameters, state, workspace = begun(scene)
    wanted, _ = direct(parameters, state.position)
    error = grid_forces(parameters, state, workspace) - wanted
    assert np.sqrt(np.sum(error**2) / np.sum(wanted**2)) < 1.3 * accuracy


def test_a_pair_pulls_alike_on_both_and_none_on_itself():
    scene = scene_of_beads(2, interaction='summation = "grid"\naccuracy = 1e-2')
    parameters, state, _ = begun(scene)
    for distance in (6.1e-5, 3e-4, 1.3e-3):
        state.position[:] = [[1e-5, 2e-5], [1e-5 + distance, 5e-5]]
        state.reference[:] = state.position
        found = grid_forces(parameters, state, FLOATING.workspace(parameters, state, 1.0))
        assert np.abs(found.sum(axis=0)).max() < 1e-12 * np.abs(found).max()
    charge = parameters.floats.charge.copy()
    charge[1] = 0.0
    alone = parameters._replace(floats=parameters.floats._replace(charge=charge))
    assert np.abs(grid_forces(alone, state, FLOATING.workspace(alone, state, 1.0))).max() < 1e-13 * np.abs(found).max()


@pytest.mark.long
@pytest.mark.compiled
def test_the_recorded_energy_is_the_direct_sum_and_forces_are_its_slope():
    scene = scene_of_beads(60, interaction='summation = "grid"\naccuracy = 1e-6')
    parameters, state, workspace = begun(scene)
    forces, energy = direct(parameters, state.position)
    assert observe(parameters, state, workspace).numbers["pair_energy"] == pytest.approx(energy, rel=3e-6)
    found, step, energies = grid_forces(parameters, state, workspace), 1e-6, []
    for moved in (-step, step):
        shifted = state._replace(position=state.position + np.array([[moved, 0.0]] + 59 * [[0.0, 0.0]]))
        energies.append(observe(parameters, shifted, workspace).numbers["pair_energy"])
    assert found[0, 0] == pytest.approx((energies[0] - energies[1]) / (2 * step), rel=1e-4)
    assert found[0, 0] == pytest.approx(forces[0, 0], rel=1e-4)


def test_the_cheaper_way_is_taken_where_none_is_asked_for():
    for count, summation, on_grid in ((4000, "auto", True), (4000, "cells", False), (200, "auto", False)):
        scene = scene_of_beads(count, interaction=f'summation = "{summation}"')
        assert (part_of(FLOATING.parameters(scene), ewald_grid.Split) is not None) == on_grid
    millimeters = f"{WATER}[[particles]]\ncount = 4000\nradius = 2e-3\ndensity = 1100.0\ncontact_angle = 1.5\n"
    assert part_of(FLOATING.parameters(scene_of(millimeters)), ewald_grid.Split) is None


def test_the_work_of_a_float_stays_the_same_from_thousands_to_a_million_whatever_the_density():
    work = []
    for count in (10_000, 100_000, 1_000_000):
        for density in (30.0, 3e3, 3e5):
            side = (count / density) ** 0.5
            statistics = ewald_grid.FloatStatistics(
                count, density, side, 0.3 * density**-0.5, 0.15 * density**-0.5, 10.2
            )
            work.append(ewald_grid.best_split(statistics, 1e-4)[0].work / count)
    assert max(work) < 8 * min(work)


@pytest.mark.parametrize(
    ("interaction", "motion", "message"),
    [
        ('summation = "grid"\nmethod = "multipole"', "", "whose long-range part is smooth: got 'multipole'"),
        ('summation = "grid"\naccuracy = 1e-11', SLOW, "or 'cells'"),
        ('summation = "grids"', SLOW, "did you mean 'grid'"),
    ],
)
def test_what_a_grid_does_not_go_with_is_reported(interaction, motion, message):
    with pytest.raises(SceneError, match=message):
        FLOATING.parameters(scene_of_beads(10, interaction=interaction, motion=motion))


def integrated(scene, pauses):
    parameters, state, workspace = begun(scene)
    for steps in pauses:
        assert FLOATING.advance(parameters, state, workspace, steps) == 0
        workspace = FLOATING.workspace(parameters, state, 1.0)
    return state


@pytest.mark.long
@pytest.mark.compiled
def test_bits_do_not_depend_on_threads_or_pauses():
    scene = scene_of_beads(
        3000, motion=SLOW + "[hydrodynamics]\nbrownian = true\n", interaction='summation = "grid"\naccuracy = 1e-3'
    )
    _jit.use_threads(1)
    once = integrated(scene, [6])
    _jit.use_threads(2)
    twice = integrated(scene, [2, 4])
    assert np.array_equal(once.position, twice.position)
    assert np.abs(once.position - FLOATING.start(scene, FLOATING.parameters(scene)).position).max() > 0.0


@pytest.mark.long
@pytest.mark.compiled
def test_an_integration_with_a_grid_is_that_with_cells():
    """Two attracting floats with inertia: the same scheme with different sums."""
    ends = []
    for how in ('summation = "cells"\naccuracy = 1e-8', 'summation = "grid"\naccuracy = 1e-8'):
        scene = scene_of_beads(8, interaction=how, motion='[integration]\nintegrator = "velocity-verlet"\n')
        parameters, state, workspace = begun(scene)
        assert FLOATING.advance(parameters, state, workspace, 5) == 0
        ends.append(state.velocity)
    assert ends[1] == pytest.approx(ends[0], rel=1e-5, abs=1e-6 * np.abs(ends[0]).max())
