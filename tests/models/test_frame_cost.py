"""What frames cost, in time and on the disk."""

import pytest

from ecume.models import MODELS
from ecume.models.costs import Content, FrameCost, frame_cost, probed
from ecume.run import run
from ecume.scenes.common import Common
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain

from .sph.scenes import PERIODIC
from .test_last_frame import SCENES


def test_a_frame_of_many_particles_is_larger():
    arrays = {"position": 2, "pressure": 1}
    small, large = probed(Content(10, arrays, 5)), probed(Content(10000, arrays, 5))
    assert 8 * 3 * 10000 < large[1] < 2 * 8 * 6 * 10000
    assert 8 * 3 * 10 < small[1] < large[1] / 10
    assert min(small[0], large[0]) > 0.0


def test_nothing_is_left_of_the_probes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    frame_cost(Common(model="floating", duration=1.0, frame_every=0.1), Content(10, {"position": 2}, 5), 10)
    assert list(tmp_path.iterdir()) == []


def test_frames_that_dominate_are_worth_a_remark():
    cost = FrameCost(6_000_001, 7200.0, 1.1e10)
    assert "frame_every" in cost.remark(44.0)
    assert cost.remark(1e5) == ""
    assert FrameCost(11, 0.05, 1e4).remark(0.01) == ""
    assert "refuses more than 30 days" in cost.remark(31 * 86400.0)
    (frames, disk) = cost.rows()
    assert frames == ("frames", "6000001", "1.2 ms and 1.83 kB each")
    assert disk == ("disk", "11 GB", "roughly, of frames and checkpoints; a larger frame_every takes less")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.compiled] if name == "sph" else []) for name in SCENES]
)
def test_the_announced_size_is_that_of_the_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = load_scene(SCENES[name].format(duration="1.8 s"))
    rows = {row[0]: row for row in MODELS[name].summary(scene)}
    assert int(rows["frames"][1]) == 61
    announced, unit = rows["disk"][1].split()
    run(scene, tmp_path / "run")
    written = sum(path.stat().st_size for path in (tmp_path / "run").rglob("*") if path.is_file())
    ratio = float(announced) * {"kB": 1e3, "B": 1.0, "MB": 1e6}[unit] / written
    assert 0.5 < ratio < 2.0


@pytest.mark.compiled
def test_the_announced_size_of_a_tank_contains_the_images_of_periodic_sides(tmp_path, monkeypatch):
    """They were not counted: 25 % of the Taylor-Green vortices."""
    monkeypatch.chdir(tmp_path)
    scene = from_plain(
        {
            "model": "sph", "duration": 0.1, "frame_every": 0.01, "spacing": 1.0 / 32.0, "gravity": 0.0,
            "liquid": {"density": 1.0, "maximum_speed": 1.0},
            "tank": {"high": [1.0, 1.0], **dict.fromkeys(("left", "right", "bottom", "top"), PERIODIC)},
            "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0], "flow": "taylor-green", "flow_speed": 1.0}],
        }
    )  # fmt: skip
    announced = {row[0]: row for row in MODELS["sph"].summary(scene)}["disk"][1]
    run(scene, tmp_path / "run")
    written = sum(path.stat().st_size for path in (tmp_path / "run").rglob("*") if path.is_file())
    assert float(announced.removesuffix(" kB").removesuffix(" MB")) * (1e6 if "MB" in announced else 1e3) == (
        pytest.approx(written, rel=0.1)
    )
