"""`ecume check` says where up is, for every model that has gravity."""

import pytest

from ecume.models import MODELS
from ecume.scenes.schema import from_plain

TANK = {
    "model": "sph", "duration": 0.01, "frame_every": 0.01, "spacing": 0.25, "liquid": {"maximum_speed": 3.0},
    "tank": {"high": [1.0, 1.0, 1.0], "top": {"kind": "open"}},
    "fluid": [{"low": [0.0, 0.0, 0.0], "high": [1.0, 0.5, 1.0]}],
}  # fmt: skip
PACKING = {
    "model": "soft", "duration": 1.0, "frame_every": 0.5, "gravity": 9.81,
    "liquid": {"viscosity": 1.0, "density": 1000.0},
    "hydrodynamics": {"drag": "stokes"},
    "particles": [{"radius": 1e-3, "modulus": 1e4, "density": 1100.0, "positions": [[0, 0, 0], [0.003, 0, 0]]}],
}  # fmt: skip
GRAIN = {
    "model": "tracers", "duration": 1.0, "frame_every": 0.5, "tank": {"high": [0.1, 0.1, 0.1]},
    "particles": [{"radius": 1e-4, "density": 2000.0, "positions": [[0.05, 0.05, 0.05]]}],
}  # fmt: skip


def row(plain):
    scene = from_plain(plain)
    return next(row for row in MODELS[scene.model].summary(scene) if row[0] == "gravity")


@pytest.mark.parametrize(("plain", "along", "up"), [(TANK, "-y", "+y"), (PACKING, "-y", "+y"), (GRAIN, "-z", "+z")])
def test_each_model_says_where_up_is(plain, along, up):
    _, value, remark = row(plain)
    assert value == f"9.81 m/s^2 along {along}"
    assert f"up is {up}" in remark


def test_an_open_top_that_is_not_above_is_remarked():
    _, value, remark = row({**TANK, "gravity": [0.0, 0.0, -9.81]})
    assert value == "9.81 m/s^2 along -z"
    assert "but the open side is top, at high y" in remark
