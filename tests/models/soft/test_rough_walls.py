"""Spheres that are glued to walls."""

import contextlib

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models.soft import SOFT
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

from .random_scenes import draw, explicit, faults, reordered, run, turned, unlike

pytestmark = [pytest.mark.compiled]

ROUGH = {
    "model": "soft", "duration": 1.0, "frame_every": 0.5, "seed": 1, "rotation": True, "liquid": {"viscosity": 1.0},
    "particles": [
        {"radius": 0.5, "modulus": 1e3, "count": 3, "glued": "bottom"},
        {"radius": 0.4, "modulus": 1e3, "count": 3, "glued": "top"},
        {"radius": {"distribution": "uniform", "mean": 0.5, "spread": 0.05}, "modulus": 1e3, "count": 10},
    ],
    "long_range_forces": {"law": "steric", "steric_strength": 0.1, "steric_length": 0.01},
    "walls": [{"side": "bottom"}, {"side": "top", "pressure": 5.0, "velocity": [0.5, 0.0]}],
    "preparation": {"pressure": 5.0, "rate": 0.3, "relaxed": 0.2},
    "cell": {"size": [4.0, 5.0]}, "integration": {"integrator": "tr-bdf2", "tolerance": 1e-3},
}  # fmt: skip


def rough(**change):
    return from_plain(ROUGH | change)


@pytest.mark.long
def test_glued_spheres_stand_on_their_wall_and_move_with_it():
    frames = list(simulate(rough()))
    for frame in frames:
        place, radius, numbers = frame.arrays["position"], frame.arrays["radius"], frame.numbers
        height = np.where(np.arange(6) < 3, radius[:6], numbers["top_y"] - radius[:6])
        assert place[:6, 1] == pytest.approx(height, abs=2e-3)
        assert frame.arrays["spin"][:6] == pytest.approx(0.0, abs=1e-6)
    moved = frames[-1].arrays["position"][3:6, 0] - frames[0].arrays["position"][3:6, 0]
    assert (moved - 0.5 + 2.0) % 4.0 - 2.0 == pytest.approx(0.0, abs=2e-3)
    assert frames[-1].arrays["velocity"][3:6, 0] == pytest.approx(0.5, abs=1e-2)


def test_forces_on_glued_spheres_are_forces_of_their_wall():
    """The pressure times the length presses on top and bottom, and the spheres between them balance."""
    frames = list(simulate(rough()))
    for frame in frames:
        numbers = frame.numbers
        assert numbers["top_force_y"] == pytest.approx(20.0, rel=1e-6)
        assert numbers["bottom_force_y"] == pytest.approx(-20.0, rel=1e-6)
        assert numbers["bottom_force_x"] == pytest.approx(-numbers["top_force_x"], rel=1e-6)
    assert frames[-1].numbers["bottom_force_x"] > 1.0


def sheared(frames, free):
    """The velocity gradient of some spheres over that between the walls, averaged over frames in which these move."""
    found = []
    for frame in frames[1:]:
        place, speed = frame.arrays["position"][free, 1], frame.arrays["velocity"][free, 0]
        found.append(np.polyfit(place, speed, 1)[0] * frame.numbers["top_y"] / 0.5)
    return np.mean(found)


@pytest.mark.long
def test_rough_walls_shear_what_slides_between_smooth_ones_as_a_whole():
    smooth = [{key: value for key, value in one.items() if key != "glued"} for one in ROUGH["particles"]]
    dragged, slid = (list(simulate(rough(duration=2.0, particles=these))) for these in (ROUGH["particles"], smooth))
    assert sheared(dragged, slice(6, None)) > 1.0
    assert sheared(slid, slice(None)) < 0.25


def test_a_wall_follows_the_force_on_its_glued_spheres():
    """Beyond the shear stress that is left of the preparation, during which walls do not move along themselves."""
    moved = {}
    for stress in (1.0, 4.0):
        walls = [{"side": "bottom"}, {"side": "top", "pressure": 5.0, "shear_stress": stress}]
        frames = list(simulate(rough(walls=walls)))
        for frame in frames:
            assert frame.numbers["top_force_x"] == pytest.approx(-4.0 * stress, rel=1e-6)
        moved[stress] = frames[-1].numbers["top_x"]
    assert moved[4.0] > max(moved[1.0], 0.0) + 0.01


def glued(dice, plain):
    """The scene with a species glued to the bottom, and sometimes one to the top."""
    kinds = plain["particles"]
    for side in ["bottom", "top"][: 1 + int(dice.random() < 0.6)]:
        layer = {key: kinds[0][key] for key in ("modulus", "radius")} | {"count": 2, "glued": side}
        kinds.append(layer)
    kinds[0]["count"] += 6
    return plain


def between_rough_walls(dice):
    """The tables of the first drawn scene with walls that can be rough, and with spheres that have room there."""
    while True:
        plain = draw(dice)
        films = plain["films"]["interface"] in ("rigid", "half-mobile")
        if "cell" in plain and plain.get("walls") and films and plain["hydrodynamics"]["drag"] == "none":
            with contextlib.suppress(SceneError):
                return explicit(from_plain(glued(dice, plain)))


@pytest.mark.long
@pytest.mark.parametrize("seed", [1, 2, 3, 5])
def test_random_packings_between_rough_walls_keep_what_every_run_keeps(seed):
    """Balance and energy, in another order, rotated, and continued from the middle."""
    dice = np.random.default_rng(seed)
    plain = between_rough_walls(dice)
    scene = from_plain(plain)
    dimensions = len(plain["cell"]["size"])
    frames, states = run(scene, keep=(2,))
    assert faults(scene, frames) == {}
    resumed, _ = run(scene, state=states[2])
    assert resumed[-1].numbers == frames[-1].numbers
    allowed = 20.0 * plain["integration"]["tolerance"]
    for changed, _ in (reordered(plain, dice), turned(plain, dice, dimensions)):
        again, _ = run(from_plain(changed))
        assert unlike(scene, frames, again) < allowed


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"walls": [{"side": "bottom"}]}, r"particles\[1\]\.glued: there is no top wall"),
        ({"hydrodynamics": {"drag": "stokes"}}, r"particles\[0\]\.glued: the drag of the liquid on a rough wall"),
        (
            {"particles": [{"radius": 0.5, "modulus": 1e3, "count": 9, "glued": "bottom"}]},
            r"particles\[0\]\.count: 2\.25 times as many spheres as have room on the bottom wall",
        ),
    ],
)
def test_impossible_rough_walls_are_refused(change, message):
    with pytest.raises(SceneError, match=message):
        rough(**change)


def test_a_wall_whose_glued_spheres_meet_no_others_is_refused():
    spheres = [*ROUGH["particles"][:2], {"radius": 0.5, "modulus": 1e3, "positions": [[1.0, 3.0], [3.0, 3.0]]}]
    plain = {key: ROUGH[key] for key in ROUGH if key != "preparation"}
    scene = from_plain(plain | {"cell": {"size": [4.0, 9.0]}, "particles": spheres})
    with pytest.raises(SceneError, match=r"no film holds the top wall"):
        SOFT.start(scene, SOFT.parameters(scene))


def test_check_names_the_rough_walls():
    rows = [(value, remark) for name, value, remark in SOFT.summary(rough()) if name == "rough wall"]
    assert rows == [
        ("bottom", "3 spheres of sphere-1 are glued to it"), ("top", "3 spheres of sphere-2 are glued to it")
    ]  # fmt: skip
