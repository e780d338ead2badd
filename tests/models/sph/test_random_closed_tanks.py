"""What holds in any closed or nearly full tank: energy less work does not rise, and solids bear their weight."""

import pytest

import ecume
from tests.models.sph.random_closed_tanks import collapsing, gained, of_rest, still

pytestmark = pytest.mark.compiled


@pytest.mark.parametrize(("pressure", "seed"), [("tait", 0), ("tait", 5), ("incompressible", 1), ("incompressible", 7)])
def test_columns_that_collapse_in_a_closed_tank_gain_no_energy(pressure, seed):
    assert gained(list(ecume.simulate(collapsing(seed, pressure)))) < 2e-3


@pytest.mark.parametrize(("pressure", "seed"), [("tait", 3), ("tait", 4), ("incompressible", 2), ("incompressible", 6)])
def test_still_liquid_bears_what_stands_in_it_on_the_floor_or_above(pressure, seed):
    scene = still(seed, pressure)
    off, speed = of_rest(list(ecume.simulate(scene)), scene)
    assert off < 0.02
    assert speed < 0.03
