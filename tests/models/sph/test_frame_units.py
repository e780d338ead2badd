"""The units of a tank's quantities: in 2D they are per meter of depth."""

import dataclasses

import pint
import pytest

from ecume.models.sph.report.observation import PER_DEPTH
from ecume.simulation import simulate

from .scenes import free_blob

EXTENSIVE = ("kinetic_energy", "total_energy", "momentum_x", "mass", "volume")


@pytest.mark.parametrize("unit", PER_DEPTH)
def test_a_quantity_per_meter_of_depth_times_a_meter_is_that_quantity(unit):
    registry = pint.UnitRegistry()
    assert registry.Quantity(1.0, f"({PER_DEPTH[unit]})*m").to(unit).magnitude == 1.0


def test_extensive_quantities_of_a_2d_tank_are_per_meter_of_depth():
    flat, solid = (
        next(iter(simulate(dataclasses.replace(free_blob(dimension), spacing=0.25)))) for dimension in (2, 3)
    )
    for name in EXTENSIVE:
        assert flat.units[name] == PER_DEPTH[solid.units[name]]
    for name in ("density", "pressure", "position", "largest_speed"):
        assert flat.units[name] == solid.units[name]
    assert flat.arrays["mass"].sum() == pytest.approx(1000.0)
    assert solid.arrays["mass"].sum() == pytest.approx(1000.0)
