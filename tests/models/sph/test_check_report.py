"""What is said of a liquid before it runs, and what its name and temperature fill in."""

import numpy as np
import pytest
from scipy.optimize import curve_fit

import ecume
from ecume.analysis.gauges import wave_amplitude
from ecume.errors import SceneError
from ecume.laws.liquids import liquid
from ecume.models.sph.record import SPH
from ecume.models.sph.report.check_report import (
    lattice_neighbors,
    neighbor_remark,
    numbers_expected,
    seconds_a_step,
)
from ecume.models.sph.setup.building import material_of
from ecume.models.sph.setup.choices import artificial_viscosity_of, tension_of
from ecume.scenes.schema import from_plain, to_plain

from .scenes import OPEN, free_blob, tank

WARM = {"name": "water", "temperature": "50 degC"}


def scene_with(liquid_table=None, **method):
    """A small tank of another liquid, or computed otherwise."""
    plain = to_plain(tank())
    table = plain["liquid"] if liquid_table is None else liquid_table
    return from_plain({**plain, "liquid": table, "method": {**plain["method"], **method}})


def said(scene):
    """By name, the value and the remark."""
    return {name: (value, remark) for name, value, remark in SPH.summary(scene)}


def test_a_name_and_a_temperature_fill_what_the_scene_leaves_out():
    material, water = material_of(scene_with(WARM)), liquid("water", 323.15)
    assert material[:1] == (water.density,)
    assert (material.viscosity, material.surface_tension) == (water.viscosity, water.surface_tension)
    assert material_of(scene_with({"name": "water"})).density == pytest.approx(998.207, abs=5e-3)


def test_what_the_scene_says_wins_over_what_the_name_says():
    material = material_of(scene_with({**WARM, "viscosity": 0.0, "density": 900.0}))
    assert (material.density, material.viscosity) == (900.0, 0.0)
    assert material.surface_tension == liquid("water", 323.15).surface_tension


def test_the_origin_of_each_number_is_reported():
    report = said(scene_with({**WARM, "density": 900.0}))
    assert report["density"] == ("900 kg/m^3", "")
    assert report["viscosity"][1] == report["surface tension"][1] == "water at 50 degrees Celsius"


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ({"name": "watr"}, "liquid.name: got 'watr'; did you mean water"),
        ({"name": "water", "temperature": "120 degC"}, "liquid.temperature: .*0 to 99.97 degrees"),
        ({"name": "water", "temperature": "120 m"}, "measures length, expected temperature"),
        ({"name": "water", "salinity": 0.03}, "liquid.salinity: water has no salinity"),
        ({"temperature": 300.0}, "has no effect without a name"),
    ],
)
def test_an_unknown_liquid_is_refused_at_its_key(table, says):
    with pytest.raises(SceneError, match=says):
        SPH.parameters(scene_with(table))


def test_a_pressure_that_nothing_asks_for_is_refused():
    with pytest.raises(SceneError, match="background_pressure: is of pressure_force"):
        SPH.parameters(scene_with(background_pressure=5.0))


def test_few_and_many_neighbors_are_reported_with_the_remedy():
    assert "raise method.smoothing_ratio" in said(scene_with(smoothing_ratio=0.9))["neighbors"][1]
    assert "lower method.smoothing_ratio" in said(scene_with(smoothing_ratio=3.0))["neighbors"][1]
    assert said(scene_with())["neighbors"] == ("44", "good")
    assert "take wendland-c2" in neighbor_remark(44, 2, "cubic-spline")


def test_the_cost_and_the_resolution_are_reported():
    report = said(scene_with())
    assert report["resolution"] == (
        "8 particles",
        "across the smallest extent of the liquid; good for the flow; 20 or more for pressures",
    )
    assert report["time step"][1].startswith("set by sound")
    assert said(scene_with({"density": 1.0, "sound_speed": 10.0, "viscosity": 5.0}))["time step"][1].startswith(
        "set by v"
    )


@pytest.mark.parametrize(("sound", "fastest"), [(3.0, 1.0), (9.0, 0.1), (30.0, 4.0)])
def test_a_slow_sound_is_reported_with_the_speed_to_set(sound, fastest):
    """Ten times the maximum speed and ten times sqrt(g H), here 1 m/s, whatever is faster."""
    remark = said(scene_with({"density": 1.0, "sound_speed": sound, "maximum_speed": fastest}))["compression"][1]
    assert remark == f"large: set liquid.sound_speed to {10.0 * max(1.0, fastest):.3g} m/s or more"


def test_the_compression_counts_the_weight_of_the_liquid():
    """A tank at rest is as dense at its floor as check says."""
    scene = scene_with({"density": 1.0, "sound_speed": 12.0, "maximum_speed": 0.3})
    state = SPH.start(scene, SPH.parameters(scene))
    value, remark = said(scene)["compression"]
    at_rest, moving = (float(part.split()[0]) for part in remark.split(", "))
    assert at_rest == pytest.approx(100.0 * (state.density.max() - 1.0), rel=0.1)
    assert moving == pytest.approx(100.0 * (0.3 / 12.0) ** 2, rel=0.05)
    assert float(value.split()[0]) == pytest.approx(at_rest + moving, rel=0.05)


def test_a_lattice_in_space_has_its_neighbors_counted():
    assert [lattice_neighbors(3, reach) for reach in (1.1, 1.5, 2.0)] == [6, 18, 26]


def channel(length, width, speed, viscosity, profile="uniform", slip="no-slip"):
    """Liquid that flows through a tank."""
    wall = {"slip": slip}
    tank_table = {
        "low": [0.0, 0.0], "high": [length, width], "bottom": wall, "top": wall,
        "left": {"kind": "inflow", "speed": speed, "profile": profile}, "right": {"kind": "outflow"},
    }  # fmt: skip
    return from_plain(
        {
            "model": "sph", "duration": 1.0, "frame_every": 0.1, "spacing": width / 10, "gravity": [0.0, 0.0],
            "liquid": {"density": 1000.0, "viscosity": viscosity}, "tank": tank_table,
            "fluid": [{"low": [0.0, 0.0], "high": [length, width]}],
        }
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(10))
def test_sound_in_a_channel_is_fast_beside_its_speed_and_its_pressure_drop(seed):
    """The compression by either is 1 % at most."""
    dice = np.random.default_rng(seed)
    width, speed, viscosity = 10.0 ** dice.uniform([-3.0, -3.0, -3.0], [0.0, 1.0, 2.0])
    length = width * dice.uniform(1.0, 10.0)
    drop = 12.0 * viscosity * speed * length / width**2
    material = material_of(channel(length, width, speed, viscosity))
    assert material.sound_speed**2 >= 99.9 * max(drop / 1000.0, (1.5 * speed) ** 2)
    assert material_of(channel(length, width, speed, viscosity, slip="free")).sound_speed == pytest.approx(15.0 * speed)


def test_a_uniform_inflow_between_no_slip_walls_is_reported():
    assert "parabolic" in said(channel(2.0, 1.0, 1.0, 1.0))["inflow left"][1]
    assert "inflow left" not in said(channel(2.0, 1.0, 1.0, 1.0, profile="parabolic"))
    assert "inflow left" not in said(channel(2.0, 1.0, 1.0, 1.0, slip="free"))


def test_a_region_that_earlier_ones_cover_is_reported():
    """A drop of oil that is listed after the water around it has no particles."""
    around, drop = {"low": [0.0, 0.0], "high": [1.0, 1.0]}, {"center": [0.5, 0.5], "radius": 0.3, "liquid": "second"}
    plain = to_plain(tank()) | {"second_liquid": {"density": 800.0}}
    assert "first listed" in said(from_plain({**plain, "fluid": [around, drop]}))["fluid[1]"][1]
    assert "fluid[1]" not in said(from_plain({**plain, "fluid": [drop, around]}))


@pytest.mark.parametrize(("walls", "says"), [("mirror", "walls are mirrors"), ("reflect", "walls only reflect")])
def test_what_holds_the_liquid_is_reported(walls, says):
    assert said(tank(walls=walls))["particles"][1] == says
    assert said(free_blob())["particles"][1] == "no walls"


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_surface_that_is_drawn_together_costs_most(dimension):
    plain = to_plain(free_blob(dimension))
    taut = from_plain({**plain, "liquid": {**plain["liquid"], "surface_tension": 0.07}})
    costs = [seconds_a_step(scene, SPH.parameters(scene), 10_000) for scene in (from_plain(plain), taut)]
    assert 3.0 < costs[1] / costs[0] < 15.0


def holding(scene):
    """Whether each mirror of the tank is a no-slip wall."""
    return SPH.parameters(scene).boundary.table[:, 3 * 2 + 1].tolist()


@pytest.mark.parametrize("name", ["water", "glycerol", "mercury", "ethanol", "seawater"])
def test_a_name_sets_properties_and_switches_nothing_on(name):
    plain, named = scene_with({}), scene_with({"name": name, "temperature": "25 degC"})
    assert material_of(named).surface_tension > 0.0
    assert material_of(named).viscosity > 0.0
    assert tension_of(named) == tension_of(plain) == "none"
    assert artificial_viscosity_of(named) == artificial_viscosity_of(plain) == 0.02
    assert sum(holding(named)) == sum(holding(plain)) == 0


def test_what_a_scene_asks_for_is_switched_on():
    asked = scene_with(WARM, surface_tension_model="csf", artificial_viscosity=0.0)
    assert (tension_of(asked), artificial_viscosity_of(asked)) == ("csf", 0.0)
    given = scene_with({"surface_tension": 0.07, "viscosity": 1e-3})
    assert (tension_of(given), artificial_viscosity_of(given)) == ("csf", 0.0)
    assert sum(holding(given)) == len(holding(given)) > sum(holding(scene_with(WARM)))


def test_dimensionless_numbers_report_neglected_effects():
    assert "is faster" in regime("Bond number", 10.0, "csf")[1]
    assert "no visible effect" not in regime("Bond number", 10.0, "none")[1]
    assert regime("Bond number", 1e-3, "none")[1].endswith('method.surface_tension_model = "csf" includes it')
    assert regime("Bond number", 1e-3, "csf")[1] == "surface tension acts"


def regime(name, size, model):
    """The row of a square of warm water."""
    plain = to_plain(tank())
    plain["spacing"] *= size
    for piece in (plain["tank"], *plain["fluid"]):
        for corner in ("low", "high"):
            piece[corner] = [size * value for value in piece[corner]]
    method = {**plain["method"], "surface_tension_model": model}
    return said(from_plain({**plain, "liquid": WARM, "method": method}))[name]


def test_the_effective_reynolds_number_counts_the_artificial_viscosity():
    """Alpha h c/(4 (d + 2)), as a standing wave loses height: pairs are damped while they approach."""
    report, [speed, sound] = said(tank(artificial_viscosity=0.08)), (1.0, 10.0)
    added = 0.08 * 0.25 * sound / 16.0
    assert float(report["effective Reynolds number"][0]) == pytest.approx(speed / added, rel=5e-3)
    assert "effective Reynolds number" not in said(tank(artificial_viscosity=0.0))


def wave_tank(alpha, **method):
    """A piston at the end of a tank of half a wavelength and more."""
    plain = to_plain(tank(16, artificial_viscosity=alpha, **method))
    plain["tank"] |= {"left": {"motion": {"amplitude": 0.01, "frequency": 0.25}}}
    return from_plain(plain)


def wave_rates(scene):
    """What `check` says of waves, as the logarithm of what is left of the height."""
    rows = [row for row in SPH.summary(scene) if row[0] == "wave damping"]
    return np.array([-np.log1p(-float(value.rstrip(" %")) / 100.0) for _, value, _ in rows]), rows


def test_the_decay_of_waves_is_reported_per_period_and_per_wavelength():
    """By viscosity, and by the method: that which viscosity adds to."""
    (all_of_it, rows), (others, _) = wave_rates(wave_tank(0.02)), wave_rates(wave_tank(0.0))
    nu, period = 0.02 * 0.125 * 10.0 / 16.0, 2.0 * np.pi / np.sqrt(np.pi * np.tanh(np.pi))
    wavenumber = (2.0 * np.pi * 0.25) ** 2  # in deep water, where energy travels half as fast as waves
    by_viscosity = [2.0 * nu * np.pi**2 * period, 2.0 * nu * wavenumber**2 * 2.0 / 0.25]
    assert all_of_it - others == pytest.approx(by_viscosity, rel=0.12)
    assert "0.25 Hz" in rows[1][2]
    completed, _ = wave_rates(wave_tank(0.0, pressure_force="corrected", viscosity_model="monaghan"))
    assert completed == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("frequency", [1e-7, 3.0, 60.0, 6e3])
def test_a_wall_of_any_frequency_is_reported_upon(frequency):
    """At 60 Hz nothing is left of a wave after its length: the logarithm of nothing ended `check` with a traceback."""
    plain = to_plain(wave_tank(0.0))
    plain["tank"]["left"]["motion"] = {"amplitude": 0.01, "frequency": frequency}
    rows = [row for row in SPH.summary(from_plain(plain)) if row[0] == "wave damping"]
    assert len(rows) == 2
    assert all(0.0 <= float(value.rstrip(" %")) <= 100.0 for _, value, _ in rows)


def test_a_maximum_speed_that_walls_exceed_is_remarked_upon():
    plain = to_plain(wave_tank(0.02))
    assert said(from_plain(plain))["maximum speed"][1] == ""
    plain["tank"]["left"]["motion"] = {"amplitude": 0.01, "frequency": 60.0}
    assert (
        said(from_plain(plain))["maximum speed"][1]
        == "falls, flows and walls reach 3.77 m/s: increase liquid.maximum_speed"
    )


def test_a_finer_spacing_is_a_remedy_only_where_viscosity_is_artificial():
    """It was that of honey, too, and a liquid that yields had the waves of one that does not."""
    assert said(wave_tank(9.0))["wave damping"][0] == "overdamped"
    assert "finer spacing" in said(wave_tank(9.0))["wave damping"][1]
    plain = to_plain(wave_tank(0.0))
    thick = said(from_plain({**plain, "liquid": {**plain["liquid"], "viscosity": 5e3}}))
    assert thick["wave damping"] == ("overdamped", "viscosity lets no wave swing")
    bare = {key: value for key, value in plain["liquid"].items() if key != "viscosity"}
    assert "wave damping" not in said(from_plain({**plain, "liquid": {**bare, "rheology": {"yield_stress": 9.0}}}))


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize(("depth", "deep"), [(1.0, 16), (0.25, 8)])
def test_a_wave_decays_as_was_announced(depth, deep):
    """By nothing but the method, in deep and in shallow water; other cases of the fit were within 10 %."""
    period = 2.0 * np.pi / np.sqrt(np.pi * np.tanh(np.pi * depth))
    speed = 0.03 * min(depth, 1.0 / np.pi) * 2.0 * np.pi / period
    scene = from_plain(
        {
            "model": "sph", "duration": 4.0 * period, "frame_every": period / 40.0, "spacing": depth / deep,
            "gravity": [0.0, -1.0], "liquid": {"density": 1.0},
            "tank": {"high": [1.0, 1.6 * depth], "top": OPEN},
            "fluid": [{"low": [0.0, 0.0], "high": [1.0, depth], "flow": "standing-wave", "flow_speed": speed}],
        }
    )  # fmt: skip
    frames = list(ecume.simulate(scene))
    times = np.array([frame.time for frame in frames])
    found = fitted_decay(times / period, np.array([wave_amplitude(frame, np.pi, 1.0) for frame in frames]))
    (announced,), _ = wave_rates(scene)
    assert found == pytest.approx(announced, rel=0.15)


def fitted_decay(periods, heights):
    """Of A exp(-d t) sin(2 pi w t + p) + c, by least squares, from 1/4 of a period on."""

    def swing(time, size, rate, frequency, phase, middle):
        return size * np.exp(-rate * time) * np.sin(2.0 * np.pi * frequency * time + phase) + middle

    late = periods > 0.25
    best, _ = curve_fit(swing, periods[late], heights[late], (np.abs(heights).max(), 0.05, 1.0, 0.0, 0.0))
    return float(best[1])


def test_the_contact_angle_is_reported_where_there_is_surface_tension():
    report = said(scene_with({"density": 1.0, "maximum_speed": 1.0, "surface_tension": 0.1}))
    assert report["contact angle"][0] == "90 degrees"
    assert "contact angle" not in said(tank())


def test_the_maximum_speed_is_that_of_a_fall_through_the_tank():
    """Of liquid and bodies that start above the floor; a pool at rest has the speed of its depth."""
    plain = to_plain(tank())
    plain["liquid"] = {"density": 1.0}
    plain["tank"] |= {"high": [1.0, 4.0]}
    fastest = material_of(from_plain(plain)).fastest
    drop = {"low": [0.4, 2.0], "high": [0.6, 2.5], "velocity": [0.0, -1.0]}
    block = {"low": [0.4, 3.0], "high": [0.6, 3.5], "density": 2.0}
    assert fastest == pytest.approx(np.sqrt(2.0))
    falling = from_plain({**plain, "fluid": [*plain["fluid"], drop]})
    assert material_of(falling).fastest == pytest.approx(np.sqrt(1.0 + 2.0 * 2.5))
    assert material_of(from_plain({**plain, "bodies": [block]})).fastest == pytest.approx(np.sqrt(2.0 * 3.0))


@pytest.mark.parametrize(
    ("change", "alpha"),
    [
        ({}, 0.02),
        ({"fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0], "flow": "standing-wave", "flow_speed": 0.1}]}, 0.0),
        ({"tank": {"high": [1.0, 2.0], "left": {"motion": {"amplitude": 0.01, "frequency": 0.25}}}}, 0.0),
        (
            {
                "tank": {"high": [1.0, 2.0], "left": {"motion": {"amplitude": 0.01, "frequency": 0.25}}},
                "method": {"acoustic_damping": 0.0},
            },
            0.02,
        ),
    ],
)
def test_waves_are_not_damped_by_default(change, alpha):
    """Where nothing else damps noise, artificial viscosity does."""
    scene = from_plain({**to_plain(tank()), **change})
    assert artificial_viscosity_of(scene) == alpha


@pytest.mark.compiled
@pytest.mark.parametrize("dimension", [2, 3])
def test_every_number_of_a_frame_is_expected(dimension):
    """With obstacles, a body, a moving side and gauges, which are most of the numbers of small tanks."""
    low, high = [0.0] * dimension, [1.0] * dimension
    scene = from_plain(
        {
            "model": "sph", "duration": 0.1, "frame_every": 0.1, "spacing": 0.125,
            "tank": {"low": low, "high": high, "top": OPEN, "left": {"motion": {"amplitude": 0.01, "frequency": 1.0}}},
            "fluid": [{"low": low, "high": [1.0, 0.5, 1.0][:dimension]}],
            "obstacles": [{"center": [0.7, 0.2, 0.5][:dimension], "radius": 0.15}],
            "bodies": [{"center": [0.3, 0.5, 0.5][:dimension], "radius": 0.15, "density": 500.0}],
            "gauges": [
                {"name": "floor", "position": [0.5, 0.0, 0.5][:dimension]},
                {"name": "flow", "position": [0.5, 0.3, 0.5][:dimension], "quantities": ["velocity", "level"]},
            ],
        }
    )  # fmt: skip
    frame = next(iter(ecume.simulate(scene)))
    assert len(numbers_expected(SPH.parameters(scene))) == len(frame.numbers)


@pytest.mark.parametrize(
    ("change", "there"),
    [
        ("tank.high=[0.5, 1.2]", True),
        ("tank.high=[0.5, 1.0]", False),
        ("method.artificial_viscosity=0.1", False),
        ("method.shifting=none", False),
        ("method.shifting=automatic", False),
    ],
)
def test_shifting_that_a_scene_selects_without_any_viscosity_is_remarked(change, there):
    text = """
    model = "sph"
    duration = 1.0
    frame_every = 0.5
    spacing = 0.1
    gravity = [0.0, -1.0]
    [liquid]
    density = 1.0
    [tank]
    high = [0.5, 1.0]
    [[fluid]]
    low = [0.0, 0.0]
    high = [0.5, 1.0]
    [method]
    artificial_viscosity = 0.0
    shifting = "delta-plus"
    """
    changes = ["tank.high=[0.5, 1.2]", change] if not change.startswith("tank") else [change]
    assert ("shifting" in said(ecume.load_scene(text, changes))) == there


def test_what_moves_the_whole_tank_is_stated_with_what_it_does_to_the_liquid():
    """A sine of 0.1 rad at 2 rad/s, about the middle of the floor of a tank of 1 m by 1.5 m."""
    plain = to_plain(tank())
    plain["duration"] = 4.0
    plain["tank"] |= {"low": [0.0, 0.0], "high": [1.0, 1.5]}
    plain["roll"] = {"amplitude": 0.1, "frequency": 1.0 / np.pi}
    plain["base_excitation"] = {"formula": ["0.3*sin(t)", "0.4*sin(t)"]}
    rows, arm = said(from_plain(plain)), np.hypot(0.5, 1.5)
    assert rows["base excitation"][0] == "500 mm/s^2"
    angle, remark = rows["roll"]
    assert angle == "5.73°"
    assert f"{1e3 * 0.4 * arm:.3g} mm/s^2 of Euler's and {1e3 * 0.04 * arm:.3g} mm/s^2 of the centrifugal" in remark
