"""What holds in any closed or nearly full tank: energy less work does not rise, and solids bear their weight."""

import math
from dataclasses import replace

import numpy as np
import pytest

import ecume
from ecume.models.sph.setup.choices import full
from tests.models.sph.random_closed_tanks import (
    collapsing,
    disordered,
    gained,
    of_rest,
    of_wall,
    opened,
    plain_of,
    risen,
    still,
)

pytestmark = pytest.mark.compiled


@pytest.mark.parametrize(("pressure", "seed"), [("tait", 0), ("tait", 5), ("incompressible", 1), ("incompressible", 7)])
def test_columns_that_collapse_in_a_closed_tank_gain_no_energy(pressure, seed):
    assert gained(list(ecume.simulate(collapsing(seed, pressure)))) < 2e-3


@pytest.mark.parametrize("seed", [5000, 7001, 7002])
def test_liquid_that_runs_up_walls_of_particles_gains_no_energy(seed):
    """It was 13, 2 and 5 % of its potential energy when pressure continued behind walls as in liquid at rest: they bore
    half of the weight of the liquid beside them, which rose too high.
    """
    frames = list(ecume.simulate(opened(seed, "incompressible")))
    assert gained(frames) < 5e-4
    assert risen(frames) < 5e-4


@pytest.mark.parametrize("seed", [1, 61, 81])
def test_bodies_that_sink_onto_the_floor_gain_no_energy(seed):
    """Liquid in gaps below a spacing gained 0.27, 0.030 and 0.30 of its potential energy in this part of the run, when
    it did not take up the compression of dummies.
    """
    scene = opened(seed, "tait")
    frames = list(ecume.simulate(replace(scene, duration=8.0 * scene.frame_every)))
    assert gained(frames) < 1e-4
    assert risen(frames) < 1e-4


@pytest.mark.parametrize("seed", [4, 10, 12])
def test_an_incompressible_liquid_gains_no_energy_but_by_the_work_on_its_compression(seed):
    """Columns collapse: liquid that an impact finds too dense expands against its pressure, by some percent of the
    energy here. Less that work energy rises by 5.1e-5 at most, and by 5.6e-4 with it.
    """
    frames = list(ecume.simulate(collapsing(seed, "incompressible")))
    work = np.array([each.numbers["numerical_work"] for each in frames])
    assert np.ptp(work) > 0.005 * abs(frames[0].numbers["potential_energy"])
    assert gained(frames) < 1e-4
    assert risen(frames) < 1e-3


@pytest.mark.parametrize("seed", [7000, 7003])
def test_no_work_is_counted_once_an_incompressible_liquid_rests(seed):
    """In pools with an obstacle it went on at 1e-3 of the potential energy in three times sqrt(H/g), since the solver's
    two operators differ where particles are disordered.
    """
    frames = list(ecume.simulate(opened(seed, "incompressible")))
    net = np.array([each.numbers["total_energy"] - each.numbers["injected_work"] for each in frames])
    assert np.ptp(net[10:]) < 3e-4 * net[0]


@pytest.mark.long
@pytest.mark.parametrize(
    ("pressure", "seed"), [*(("tait", seed) for seed in (3, 4, 11)), *(("incompressible", k) for k in (1, 2, 3, 6, 18))]
)
def test_still_liquid_bears_what_stands_in_it_on_the_floor_or_above(pressure, seed):
    scene = still(seed, pressure)
    frames = list(ecume.simulate(scene))
    off, speed = of_rest(frames, scene)
    assert off < 0.015
    assert of_wall(frames, scene.fluid[0].high[1]) < 0.01
    assert speed < 0.03


@pytest.mark.long
@pytest.mark.parametrize("pressure", ["tait", "incompressible"])
def test_forces_do_not_depend_on_whether_a_tank_counts_as_full(pressure):
    """Methods are chosen once, at the start, by volume. They stay right where a run fills or empties a tank: from 1 %
    of air over the limit of a full tank to none, solids bear the weight of the liquid.
    """
    for filled, is_full in ((1.0, True), (0.997, True), (0.99, False), (0.94, False)):
        fluid, solids = [{"low": [0.0, 0.0], "high": [1.0, filled]}], [{"center": [0.5, 0.5], "radius": 0.2}]
        scene = plain_of(1.0 / 16.0, {"high": [1.0, 1.0]}, fluid, pressure, 1.0, obstacles=solids)
        assert full(scene) == is_full
        frames = list(ecume.simulate(scene))
        late = [each.numbers for each in frames[20:]]
        weight = frames[0].arrays["mass"].sum()
        down = np.mean([sum(each[f"{name}_force_y"] for name in ("bottom", "top", "obstacle0")) for each in late])
        lift = np.mean([each["obstacle0_force_y"] for each in late])
        assert down == pytest.approx(-weight, rel=5e-3)
        assert lift == pytest.approx(math.pi * 0.2**2, rel=0.02)
        assert late[-1]["largest_speed"] < 0.03


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2))
def test_disordered_liquid_without_viscosity_gains_no_energy_in_a_full_periodic_tank(seed):
    """It gained 3 to 10 % of its potential energy, since shifting changed densities as if the volume could change."""
    frames = list(ecume.simulate(disordered(seed)))
    assert gained(frames) < 1.5e-3
    assert frames[-1].numbers["largest_speed"] < 0.05
