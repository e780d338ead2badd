"""Sides that move, and tanks that are shaken."""

import json
import math

import numpy as np
import pytest

import ecume
from ecume.errors import SceneError
from ecume.models.sph.boundaries.rigid_bodies import drive_at
from ecume.models.sph.record import SPH
from ecume.models.sph.report.observation import invariants
from ecume.run import RunDirectory
from ecume.run.invariant_monitor import Watch
from ecume.scenes.schema import from_plain, to_plain
from tests.models.sph.scenes import tank
from tests.models.sph.test_solids import changed

SHAKE = {"amplitude": [0.05, 0.0], "frequency": 0.2}
PUSH = {"times": [0.0, 1.0], "positions": [0.0, 0.2]}


def with_side(scene, name, **keys):
    plain = to_plain(scene)
    plain["tank"][name] = {**plain["tank"][name], **keys}
    return from_plain(plain)


def sway(time, length=1.0, depth=1.0, gravity=1.0):
    """How far the middle of the liquid goes to the side, by the linear theory of potential flow: each odd mode is an
    oscillator that the pull drives from rest.
    """
    drive, total = 2.0 * math.pi * SHAKE["frequency"], 0.0
    for n in (1, 3, 5):
        wave = n * math.pi / length
        own = math.sqrt(gravity * wave * math.tanh(wave * depth))
        shape = -4.0 * length / (n * math.pi) ** 2
        height = shape * SHAKE["amplitude"][0] / gravity * own**2 / (own**2 - drive**2)
        total += 0.5 * shape / depth * height * (math.sin(drive * time) - drive / own * math.sin(own * time))
    return total


@pytest.mark.long
@pytest.mark.compiled
def test_a_shaken_tank_sloshes_as_linear_theory_has_it(tmp_path):
    scene = changed(tank(deep=16, jitter=0.0), base_excitation=SHAKE, duration=4.0)
    frames = list(ecume.simulate(scene))
    found = np.array([frame.numbers["center_x"] - 0.5 for frame in frames])
    wanted = np.array([sway(frame.time) for frame in frames])
    assert np.abs(wanted).max() > 5e-3
    # Sixteen particles deep it sloshes about one percent too slowly.
    assert np.abs(found - wanted).max() < 0.1 * np.abs(wanted).max()
    # Excitation and density diffusion do all the work; the rest is lost to artificial viscosity: 8 % without diffusion.
    energy, work = (np.array([one.numbers[key] for one in frames]) for key in ("total_energy", "injected_work"))
    assert work[-1] > 8e-4
    rest = energy - energy[0] - work
    assert rest.max() < 1e-6 * work[-1]
    assert -0.085 * work[-1] < rest[-1] < -0.06 * work[-1]
    watch = Watch(RunDirectory(tmp_path), invariants(scene, SPH.parameters(scene)), "stop")
    for number, frame in enumerate(frames):
        watch.take(frame.time, frame.numbers, number)
    watch.keep()
    report = json.loads((tmp_path / "watch.json").read_text())
    assert "energy" in [one["name"] for one in report["invariants"] if one["held"]]
    assert report["energy"]["injected"] == work[-1]
    assert report["energy"]["dissipated"] == pytest.approx(work[-1] - energy[-1] + energy[0])


@pytest.mark.compiled
def test_a_piston_pushes_what_is_before_it():
    last = list(ecume.simulate(with_side(tank(jitter=0.0), "left", motion=PUSH)))[-1]
    x, y = last.arrays["position"].T
    assert x.min() > 0.2
    assert x[y < 0.6].min() == pytest.approx(0.2 + 1 / 16, abs=0.02)
    assert np.median(y) > 0.55


@pytest.mark.compiled
def test_a_wall_that_starts_moving_does_work_on_the_liquid():
    """The rate of the liquid's energy is the force on the wall times its speed, less what viscosity takes."""
    scene = with_side(tank(jitter=0.0), "left", motion={"amplitude": -0.1, "frequency": 0.25, "phase": math.pi / 2})
    frames = list(ecume.simulate(scene))
    parameters = SPH.parameters(scene)
    work, before = 0.0, None
    for frame in frames:
        rate = drive_at(parameters.drives[0][1], frame.time)[1][0]
        power = -frame.numbers["left_force_x"] * rate
        work += 0.0 if before is None else 0.05 * (power + before)
        before = power
    gained = frames[-1].numbers["total_energy"] - frames[0].numbers["total_energy"]
    assert work > 0.02
    assert gained == pytest.approx(work, rel=0.25)


@pytest.mark.parametrize(
    ("motion", "walls", "said"),
    [
        ({"amplitude": 0.1}, "mirror", "tank.left.motion.frequency"),
        ({"times": [0, 1], "positions": [0]}, "mirror", "tank.left.motion.positions"),
        ({"times": [1, 0], "positions": [0, 1]}, "mirror", "ascend"),
        ({"amplitude": 0.1, "frequency": 1.0}, "dummy", "mirror"),
    ],
)
def test_a_motion_that_cannot_be_says_why(motion, walls, said):
    with pytest.raises(SceneError) as caught:
        with_side(tank(walls=walls), "left", motion=motion)
    assert said in str(caught.value)
