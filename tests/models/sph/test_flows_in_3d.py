"""Flows in space, and flows with sums in single precision, against what is exact."""

import math

import numpy as np
import pytest

import ecume
from ecume.laws import flows
from ecume.scenes.schema import from_plain
from tests.models.sph.scenes import PERIODIC
from tests.oracles.swirls import beltrami_pressure, beltrami_velocity

pytestmark = pytest.mark.compiled

VISCOSITY = 0.02
TURN = 2.0 * math.pi
SIDES = ("left", "right", "bottom", "top", "front", "back")
SOUND = 20.0


def last_of(case):
    (*_, last) = ecume.simulate(case)
    return last


def swirl(place, speed=1.0):
    """The flow of Arnold, Beltrami and Childress in a unit cube, (N, 3)."""
    x, y, z = TURN * place.T
    parts = ((y, z), (z, x), (x, y))
    return np.stack([beltrami_velocity(*phases, speed) for phases in parts], axis=-1)


def swirls(side, precision):
    """So many particles a side, out of order by up to a tenth of a spacing, with the pressure of the flow."""
    along = (np.arange(side) + 0.5) / side
    place = np.stack(np.meshgrid(along, along, along, indexing="ij"), axis=-1).reshape(-1, 3)
    place = (place + np.random.default_rng(1).uniform(-0.1, 0.1, place.shape) / side) % 1.0
    velocity = swirl(place, 1.0 / math.sqrt(3.0))
    pressure = beltrami_pressure((velocity**2).sum(axis=1), 1.0 / math.sqrt(3.0), 1.0)
    density = 1.0 + pressure / SOUND**2
    particles = {"positions": place, "velocities": velocity, "densities": density, "masses": density / side**3}
    return from_plain(
        {
            "model": "sph",
            "duration": 0.25,
            "frame_every": 0.25,
            "spacing": 1.0 / side,
            "gravity": [0.0, 0.0, 0.0],
            "liquid": {
                "density": 1.0, "sound_speed": SOUND, "maximum_speed": 1.8, "viscosity": VISCOSITY,
                "tait_exponent": 1.0,
            },
            "tank": {"low": [0.0, 0.0, 0.0], "high": [1.0, 1.0, 1.0], **dict.fromkeys(SIDES, PERIODIC)},
            "fluid": [{"particles": {name: array.tolist() for name, array in particles.items()}}],
            "method": {"precision": precision},
        }
    )  # fmt: skip


def error_of(frame):
    """Root mean square over that of the exact flow, which only fades."""
    faded = math.exp(-VISCOSITY * TURN**2 * frame.time)
    exact = faded * swirl(frame.arrays["position"], 1.0 / math.sqrt(3.0))
    return math.sqrt(((frame.arrays["velocity"] - exact) ** 2).sum(axis=1).mean()) / faded


@pytest.mark.long
def test_swirls_in_space_only_fade_with_an_error_that_shrinks_in_either_precision():
    coarse, fine = (last_of(swirls(side, "double")) for side in (6, 10))
    assert error_of(fine) < 0.035
    assert math.log(error_of(coarse) / error_of(fine)) / math.log(10 / 6) > 1.2
    single = last_of(swirls(6, "single"))
    assert error_of(single) == pytest.approx(error_of(coarse), rel=1e-3)
    assert 0.0 < np.abs(single.arrays["velocity"] - coarse.arrays["velocity"]).max() < 1e-5


def channel(precision, across=12):
    """Between plates, driven from rest, thin along both other axes."""
    thin = 5.0 / across
    return from_plain(
        {
            "model": "sph",
            "duration": 0.6,
            "frame_every": 0.6,
            "spacing": 1.0 / across,
            "gravity": [0.8, 0.0, 0.0],
            "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0, "viscosity": 0.1},
            "tank": {
                "low": [0.0, 0.0, 0.0],
                "high": [thin, 1.0, thin],
                **dict.fromkeys(("left", "right", "front", "back"), PERIODIC),
            },
            "fluid": [{"low": [0.0, 0.0, 0.0], "high": [thin, 1.0, thin]}],
            "method": {"precision": precision, "jitter": 0.2},
        }
    )


@pytest.mark.long
@pytest.mark.parametrize("precision", ["double", "single"])
def test_a_channel_between_plates_in_space_starts_as_its_series_says(precision):
    last = last_of(channel(precision))
    speed, height = last.arrays["velocity"], np.clip(last.arrays["position"][:, 1], 0.0, 1.0)
    exact = np.array([flows.poiseuille_start(y, last.time, 1.0, 0.1, 0.8) for y in height])
    assert np.abs(speed[:, 0] - exact).max() < 0.03 * exact.max()
    assert np.abs(speed[:, 1:]).max() < 0.02 * exact.max()


@pytest.mark.long
def test_vortices_in_a_plane_fade_alike_in_either_precision():
    around = dict.fromkeys(SIDES[:4], PERIODIC)
    found = {}
    for precision in ("double", "single"):
        found[precision] = last_of(
            from_plain(
                {
                    "model": "sph",
                    "duration": 0.5,
                    "frame_every": 0.5,
                    "spacing": 0.05,
                    "gravity": [0.0, 0.0],
                    "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0, "viscosity": 0.01},
                    "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0], **around},
                    "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0], "flow": "taylor-green"}],
                    "method": {"jitter": 0.1, "precision": precision},
                }
            )
        )
    faded = math.exp(-flows.taylor_green_decay(TURN, TURN, 0.01) * 0.5)
    assert found["single"].numbers["kinetic_energy"] == pytest.approx(0.25 * faded**2, rel=0.04)
    off = np.abs(found["single"].arrays["velocity"] - found["double"].arrays["velocity"]).max()
    assert 0.0 < off < 1e-3


@pytest.mark.long
@pytest.mark.parametrize("precision", ["double", "single"])
def test_a_tank_out_of_order_comes_to_rest_in_either_precision(precision):
    case = from_plain(
        {
            "model": "sph",
            "duration": 20.0,
            "frame_every": 20.0,
            "spacing": 1.0 / 12,
            "gravity": [0.0, -1.0],
            "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0},
            "tank": {"low": [0.0, 0.0], "high": [1.0, 1.5], "top": {"kind": "open"}},
            "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0]}],
            "method": {"precision": precision, "jitter": 0.2},
        }
    )
    last = last_of(case)
    off = last.arrays["pressure"] - (1.0 - last.arrays["position"][:, 1])
    assert math.sqrt((off**2).mean()) < 0.015
    assert math.sqrt((last.arrays["velocity"] ** 2).sum(axis=1).mean()) < 5e-3
    assert last.numbers["guard_hits"] == 0.0
