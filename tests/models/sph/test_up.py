"""Tanks in which z points up: the results of the same tank with y and z exchanged."""

import os
import re

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.models import MODELS
from ecume.scenes.quantities import SIDES
from ecume.scenes.schema import from_plain

VECTORS = ("low", "high", "center", "position", "velocity", "axis")
"""Keys that hold vectors."""
SPACING = 0.1
LONG = 0.003 if os.environ.get("NUMBA_DISABLE_JIT") == "1" else 0.01
"""s: a step or two as plain Python."""
BOX = {"box_height": "box_depth", "box_depth": "box_height"}
"""Sides of a periodic tank, which are exchanged, too."""


def exchanged(value, key=""):
    """The plain scene with y and z exchanged in each vector; turning vectors change their sign in a mirror."""
    if isinstance(value, dict):
        return {name: exchanged(each, name) for name, each in value.items()}
    if isinstance(value, list) and key in VECTORS:
        return [value[0], value[2], value[1]]
    if isinstance(value, list) and key == "spin":
        return [-value[0], -value[2], -value[1]]
    return [exchanged(each) for each in value] if isinstance(value, list) else value


def random_tank(seed):
    """A tank with some of: a ball that floats, a block, a lid or piston that moves, periodic ends, an inflow."""
    random = np.random.default_rng(seed)
    cells = random.integers(3, 6, 3)
    wide, high, deep = (SPACING * cells).tolist()
    level = SPACING * int(random.integers(2, cells[1] + 1))
    tank = {"high": [wide, high + 0.2, deep], "top": {"kind": "open"}}
    plain = {
        "model": "sph", "duration": LONG, "frame_every": LONG, "spacing": SPACING, "tank": tank,
        "liquid": {"maximum_speed": 3.0, "viscosity": float(random.choice([0.0, 1.0]))},
        "fluid": [{"low": [0.0, 0.0, 0.0], "high": [wide, level, deep], "velocity": random.normal(0, 0.1, 3).tolist()}],
        "gauges": [
            {"name": "wet", "position": [wide / 2, SPACING, deep / 3], "quantities": ["pressure", "velocity", "level"]},
            {"name": "still", "position": [wide / 3, 0.0, deep / 3], "quantities": ["hydrostatic_pressure"]},
        ],
    }  # fmt: skip
    choice = seed % 6
    if choice == 0:
        tank["left"] = {"motion": {"amplitude": 0.01, "frequency": 2.0}}
    elif choice == 1:
        tank["front"], tank["back"] = {"kind": "periodic"}, {"kind": "periodic"}
    elif choice == 2:
        tank["bottom"] = {"velocity": [0.3, 0.0, 0.1]}
    elif choice == 3:
        middle = [wide / 2, level, deep / 2]
        spin = random.normal(0, 1, 3).tolist()
        ends = [[x + sign * half for x, half in zip(middle, (0.1, 0.12, 0.1), strict=True)] for sign in (-1, 1)]
        plain["bodies"] = [{"low": ends[0], "high": ends[1], "density": 600.0, "spin": spin}]
    elif choice == 4:
        plain["obstacles"] = [{"low": [SPACING, 0.0, SPACING], "high": [2 * SPACING, SPACING, 2 * SPACING]}]
    else:
        tank["left"] = {"kind": "inflow", "speed": 0.5, "level": level, "profile": str(random.choice(PROFILES))}
        tank["right"] = {"kind": "outflow", "level": level}
        plain["fluid"][0]["velocity"] = [0.5, 0.0, 0.0]
    return plain


PROFILES = ("uniform", "parabolic")


def last(plain):
    *_, frame = ecume.simulate(from_plain(plain))
    return frame


def named(name):
    """The name of a number in the exchanged frame, and its sign there."""
    if not re.search(r"_q?[xyz]$", name):
        return BOX.get(name, name), 1.0
    sign = -1.0 if re.search(r"spin|torque|_q", name) else 1.0
    return name[:-1] + {"x": "x", "y": "z", "z": "y"}[name[-1]], sign


# Each kind of tank once as plain Python, which takes seconds for a tank, and twice compiled.
@pytest.mark.parametrize(
    "seed", [*range(6), *(pytest.param(seed, marks=pytest.mark.compiled) for seed in range(6, 12))]
)
def test_z_up_is_y_up_with_both_exchanged(seed):
    plain = random_tank(seed)
    upright, turned = last(plain), last({**exchanged(plain), "up": "z"})
    loads = {name: value for name, value in upright.numbers.items() if "force" in name or "torque" in name}
    # Images beyond an edge count to one of its two sides; which one depends on the order of the axes.
    exact, shared = (1e-5 if "bodies" in plain else 1e-9), 2e-3 * max(map(abs, loads.values()))
    for name, value in upright.numbers.items():
        other, sign = named(name)
        close = shared if name in loads else 2e-3 * abs(value) if name == "injected_work" else exact
        assert sign * turned.numbers[other] == pytest.approx(value, rel=exact, abs=close), name
    for axis, other in zip("xyz", "xzy", strict=True):
        total, same = (
            sum(frame.numbers.get(f"{side}_force_{k}", 0.0) for side in SIDES)
            for frame, k in ((upright, axis), (turned, other))
        )
        assert same == pytest.approx(total, abs=1e-5 * max(map(abs, loads.values())))
    one, two = upright.arrays["position"], turned.arrays["position"][:, [0, 2, 1]]
    order = [np.lexsort(np.round(places, 6).T) for places in (one, two)]
    assert two[order[1]] == pytest.approx(one[order[0]], abs=exact * SPACING)
    pressures = upright.arrays["pressure"][order[0]], turned.arrays["pressure"][order[1]]
    assert pressures[1] == pytest.approx(pressures[0], abs=10 * exact * np.abs(pressures[0]).max())


@pytest.mark.parametrize("flow", ["standing-wave", "poiseuille", "taylor-green"])
def test_named_flows_turn_with_it(flow):
    plain = random_tank(2)
    plain["tank"].pop("bottom")
    plain["fluid"][0].pop("velocity")
    plain["fluid"][0].update(flow=flow, flow_speed=0.1)
    upright = MODELS["sph"].start(from_plain(plain), *_parts(plain))
    turned = MODELS["sph"].start(from_plain({**exchanged(plain), "up": "z"}), *_parts({**exchanged(plain), "up": "z"}))
    assert np.abs(upright.velocity[1]).max() == pytest.approx(np.abs(turned.velocity[2]).max())
    assert np.abs(turned.velocity[1]).max() == 0.0


def _parts(plain):
    return (MODELS["sph"].parameters(from_plain(plain)),)


def test_a_tank_laid_as_in_cad_feels_its_weight_on_the_floor():
    """The tank of the review: x length, y width, z height; its gauge read 0 Pa, and its open side was beside."""
    plain = {
        "model": "sph", "duration": 0.01, "frame_every": 0.01, "spacing": 0.1, "up": "z",
        "tank": {"high": [0.6, 0.4, 0.8], "top": {"kind": "open"}},
        "fluid": [{"low": [0, 0, 0], "high": [0.6, 0.4, 0.5]}],
        "gauges": [{"name": "floor", "position": [0.3, 0.2, 0.0], "quantities": ["pressure", "level"]}],
    }  # fmt: skip
    frame = next(iter(ecume.simulate(from_plain(plain))))
    assert frame.numbers["floor_pressure"] == pytest.approx(1000 * 9.81 * 0.5, rel=0.02)
    assert frame.numbers["floor_level"] == pytest.approx(0.5, rel=0.02)
    assert frame.numbers["top"] == pytest.approx(0.45)


def gravity_row(**more):
    plain = {
        "model": "sph", "duration": 0.01, "frame_every": 0.01, "spacing": 0.1,
        "tank": {"high": [0.6, 0.4, 0.8], "top": {"kind": "open"}},
        "fluid": [{"low": [0, 0, 0], "high": [0.6, 0.4, 0.5]}],
    }  # fmt: skip
    scene = from_plain({**plain, **more})
    return next(row for row in MODELS["sph"].summary(scene) if row[0] == "gravity")


def test_a_tank_that_seems_to_have_z_up_is_remarked_on():
    assert 'write up = "z"' in gravity_row()[2]
    assert 'write up = "z"' in gravity_row(gravity=[0.0, 0.0, -9.81])[2]
    assert gravity_row(up="z") == ("gravity", "9.81 m/s^2 along -z", "up is +z, the side top")


def test_a_flat_tank_has_no_z():
    plain = random_tank(0)
    plain["tank"] = {"high": [1.0, 1.0]}
    plain |= {"fluid": [{"low": [0, 0], "high": [1, 1]}], "gauges": [], "up": "z"}
    with pytest.raises(SceneError, match="up: got 'z'; expected 'y' in 2D"):
        from_plain(plain)
