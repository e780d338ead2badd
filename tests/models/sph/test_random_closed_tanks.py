"""What holds in any closed or nearly full tank: energy less work does not rise, and solids bear their weight."""

import math

import numpy as np
import pytest

import ecume
from ecume.models.sph.setup.choices import full
from tests.models.sph.random_closed_tanks import collapsing, gained, of_rest, of_wall, opened, plain_of, still

pytestmark = pytest.mark.compiled


@pytest.mark.parametrize(("pressure", "seed"), [("tait", 0), ("tait", 5), ("incompressible", 1), ("incompressible", 7)])
def test_columns_that_collapse_in_a_closed_tank_gain_no_energy(pressure, seed):
    assert gained(list(ecume.simulate(collapsing(seed, pressure)))) < 2e-3


def test_a_jet_that_rises_along_a_wall_gains_little_energy():
    """1.4 % of its potential energy. It was 13 % when walls of particles carried half of the weight of jets beside them,
    and those rose twice as high.
    """
    assert gained(list(ecume.simulate(opened(5000, "incompressible")))) < 0.03


@pytest.mark.parametrize("seed", [4, 10, 12])
def test_what_an_incompressible_liquid_gains_is_the_work_that_corrects_its_density(seed):
    """At impacts energy rises by up to 0.12 % here, since liquid that is too dense expands against their pressure. Less
    that work it does not rise.
    """
    frames = list(ecume.simulate(collapsing(seed, "incompressible")))
    total, work = (np.array([each.numbers[name] for each in frames]) for name in ("total_energy", "numerical_work"))
    weight = abs(frames[0].numbers["potential_energy"])
    rise = (total - np.minimum.accumulate(total)).max() / weight
    assert rise > 4e-4
    assert np.ptp(work) > 0.01 * weight
    assert gained(frames) < 1e-5


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
