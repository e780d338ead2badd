"""Liquids by name: against reference formulations, and their published check values."""

import math

import pytest

from ecume.citing import bibliography, cited
from ecume.errors import BadInput
from ecume.laws import liquids
from ecume.laws.liquids import LIQUIDS, liquid
from ecume.show.style import LIQUID_COLORS

IAPWS = {
    # degrees Celsius: density (IAPWS-95), viscosity (IAPWS 2008), speed of sound (IAPWS-95), at 101325 Pa
    0.01: (999.84376, 1.791131e-3, 1402.4330),
    10.0: (999.70247, 1.305900e-3, 1447.2722),
    20.0: (998.20715, 1.001596e-3, 1482.3462),
    25.0: (997.04764, 8.900225e-4, 1496.7014),
    40.0: (992.21635, 6.527287e-4, 1528.9045),
    60.0: (983.19582, 4.660351e-4, 1550.9735),
    80.0: (971.79040, 3.540507e-4, 1554.4302),
    99.0: (959.06606, 2.845653e-4, 1544.0271),
}
TENSIONS = {0.01: 75.65, 10.0: 74.22, 20.0: 72.74, 30.0: 71.19, 50.0: 67.94, 80.0: 62.67, 100.0: 58.91}
"""mN/m, the table of the IAPWS release."""


@pytest.mark.parametrize(("celsius", "expected"), IAPWS.items())
def test_water_is_that_of_the_reference_formulations(celsius, expected):
    found = liquid("water", 273.15 + celsius)
    density, viscosity, sound_speed = expected
    assert found.density == pytest.approx(density, rel=4e-6 if celsius <= 60.0 else 2e-5)
    assert found.viscosity == pytest.approx(viscosity, rel=1e-3)
    assert found.sound_speed == pytest.approx(sound_speed, abs=0.08)
    assert found.kinematic_viscosity == found.viscosity / found.density


@pytest.mark.parametrize(("celsius", "expected"), TENSIONS.items())
def test_the_surface_tension_of_water_is_the_table_of_the_release(celsius, expected):
    assert 1e3 * liquids.water_surface_tension(273.15 + celsius) == pytest.approx(expected, abs=0.006)


@pytest.mark.parametrize(
    ("celsius", "salinity", "expected"),
    [(5.0, 0.0, 999.96675), (5.0, 0.035, 1027.67547), (25.0, 0.0, 997.04796), (25.0, 0.035, 1023.34306)],
)
def test_seawater_has_the_check_values_of_its_equation_of_state(celsius, salinity, expected):
    assert liquids.seawater_density(273.15 + celsius, salinity) == pytest.approx(expected, abs=6e-6)


def test_sound_in_the_sea_has_the_check_value_of_the_nine_term_equation():
    depth = 1.630e-2 * 1000.0 + 1.675e-7 * 1000.0**2 - 7.139e-13 * 25.0 * 1000.0**3
    assert liquids.seawater_sound_speed(298.15, 0.035) + depth == pytest.approx(1550.744, abs=6e-4)


def test_salt_makes_water_denser_thicker_and_faster():
    sea, fresh = liquid("seawater", 288.15), liquid("water", 288.15)
    assert sea.density > fresh.density + 20.0
    assert 1.05 < sea.viscosity / fresh.viscosity < 1.1
    assert sea.surface_tension > fresh.surface_tension
    assert sea.sound_speed > fresh.sound_speed + 30.0
    assert liquid("seawater", 288.15, 0.03).density < sea.density


@pytest.mark.parametrize("celsius", [2.0, 10.0, 20.0, 30.0])
def test_salt_thickens_water_as_an_older_correlation_says(celsius):
    """Millero's of 1974, from the volume chlorinity; ours is said to be within 1.5 %."""
    chlorinity = liquids.seawater_density(273.15 + celsius, 0.035) * 35.0 / 1806.55
    ratio = 1.0 + (5.185e-5 * celsius + 1.0675e-4) * chlorinity**0.5 + (3.3e-5 * celsius + 2.591e-3) * chlorinity
    found = liquids.seawater_viscosity(273.15 + celsius, 0.035) / liquids.water_viscosity(273.15 + celsius)
    assert found == pytest.approx(ratio, rel=0.015)


HANDBOOK = {
    # density, viscosity, surface tension, speed of sound at 25 degrees Celsius: handbook values, rounded
    "ethanol": (785.1, 1.074e-3, 21.97e-3, 1144.0),
    "glycerol": (1258.0, 0.934, 63.0e-3, 1904.0),
    "mercury": (13533.6, 1.526e-3, 485.5e-3, 1450.0),
}


@pytest.mark.parametrize(("name", "expected"), HANDBOOK.items())
def test_other_liquids_are_those_of_the_handbooks(name, expected):
    found = liquid(name, 298.15)
    density, viscosity, tension, sound_speed = expected
    assert found.density == pytest.approx(density, rel=4e-3)
    assert found.viscosity == pytest.approx(viscosity, rel=0.05)
    assert found.surface_tension == pytest.approx(tension, rel=0.015)
    assert found.sound_speed == pytest.approx(sound_speed, rel=5e-3)


@pytest.mark.parametrize(
    ("name", "density", "viscosity", "tension"),
    [
        ("milk", 1029.0, 2e-3, 0.0524), ("soapy water", 998.0, 1e-3, 0.039), ("olive oil", 911.0, 0.083, 0.032),
        ("sunflower oil", 919.0, 0.063, 0.033), ("honey", 1420.0, 12.0, 0.055), ("coffee", 1000.0, 1.05e-3, 0.05),
        ("syrup", 1286.5, 0.0585, 0.0765),
    ],
)  # fmt: skip
def test_liquids_of_the_kitchen_have_typical_values_and_sources(name, density, viscosity, tension):
    found = liquid(name, 293.15)
    assert found.density == pytest.approx(density, rel=0.01)
    assert found.viscosity == pytest.approx(viscosity, rel=0.1)
    assert found.surface_tension == pytest.approx(tension, rel=0.05)
    assert all(cited(part.__doc__) for part in LIQUIDS[name] if callable(part))
    assert {key for part in LIQUIDS[name] if callable(part) for key in cited(part.__doc__)} <= bibliography().keys()


def test_honey_is_as_viscous_as_its_table_says():
    assert liquid("honey", 298.15).viscosity == pytest.approx(6.9, rel=0.03)


def test_each_liquid_has_a_color():
    assert LIQUIDS.keys() <= LIQUID_COLORS.keys()


@pytest.mark.parametrize("name", LIQUIDS)
def test_a_warmer_liquid_is_thinner_with_a_weaker_surface(name):
    low, high = (liquid(name, bound) for bound in (LIQUIDS[name].coldest, LIQUIDS[name].hottest))
    assert high.viscosity < low.viscosity
    assert high.surface_tension < low.surface_tension
    assert high.density < low.density


@pytest.mark.parametrize("name", LIQUIDS)
@pytest.mark.parametrize("temperature", [-5.0, 260.0, 400.0, math.nan, math.inf])
def test_beyond_the_data_there_is_no_liquid(name, temperature):
    with pytest.raises(BadInput, match=f"temperature of {name} .* degrees Celsius"):
        liquid(name, temperature)


def test_celsius_instead_of_kelvin_is_guessed():
    with pytest.raises(BadInput, match=r"did you mean 293.15 K, 20 degrees Celsius"):
        liquid("water", 20.0)


def test_grams_instead_of_kilograms_of_salt_are_guessed():
    with pytest.raises(BadInput, match=r"did you mean 0.035, 35 grams"):
        liquid("seawater", 293.15, 35.0)


def test_only_the_sea_is_salty():
    with pytest.raises(BadInput, match="no salinity"):
        liquid("ethanol", 293.15, 0.03)


def test_misspelt_liquids_are_guessed():
    with pytest.raises(BadInput, match=r"did you mean 'glycerol'"):
        liquid("glycerin", 293.15)
