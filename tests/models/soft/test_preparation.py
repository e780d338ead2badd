"""A packing that is compressed and relaxed before time 0."""

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models.soft import SOFT
from ecume.models.soft.preparation import compression
from ecume.models.soft.setup import compression_rate
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

from .random_scenes import draw, explicit, faults, run

pytestmark = [pytest.mark.compiled]

LOOSE = {
    "model": "soft", "duration": 4.0, "frame_every": 1.0, "seed": 1, "rotation": True, "liquid": {"viscosity": 1.0},
    "particles": [{"radius": radius, "modulus": 5e4, "count": 6} for radius in (1e-3, 1.4e-3)],
    "long_range_forces": {"law": "steric", "steric_strength": 5e-5, "steric_length": 1e-5},
    "cell": {"size": [1.0, 1.0], "volume_fraction": 0.75},
    "integration": {"integrator": "tr-bdf2", "tolerance": 1e-3},
}  # fmt: skip


def prepared(preparation, **more):
    return from_plain(LOOSE | {"preparation": {"rate": 0.1, **preparation}} | more)


def test_a_packing_is_at_its_volume_fraction_and_at_rest_when_time_begins():
    scene = prepared({"volume_fraction": 0.87, "relaxed": 0.02}, duration=10.0, frame_every=10.0)
    first, last = simulate(scene)
    assert first.time == first.numbers["time_steps"] == first.numbers["strain"] == 0.0
    assert first.numbers["volume_fraction"] == pytest.approx(0.87, rel=1e-12)
    # A time of 1/rate later forces have changed by less than the part: less than in the time before.
    tension = [np.sort(frame.arrays["tension"].ravel()) for frame in (first, last)]
    assert np.sqrt(((tension[1] - tension[0]) ** 2).sum() / (tension[1] ** 2).sum()) < 0.02
    assert last.numbers["pressure"] > 0.1


@pytest.mark.long
def test_a_packing_begins_at_the_pressure_to_which_it_was_compressed():
    scene = prepared({"pressure": "0.1 N/m"}, protocol=[{"time": 0.0, "pressure": "0.1 N/m"}])
    frames = list(simulate(scene))
    assert [frame.numbers["pressure"] for frame in frames] == pytest.approx([0.1] * 5, rel=1e-8)
    fractions = [frame.numbers["volume_fraction"] for frame in frames]
    assert fractions[0] > 0.82
    assert fractions == pytest.approx([fractions[0]] * 5, rel=1e-3)


@pytest.mark.long
def test_a_smaller_part_leaves_a_packing_alone_for_longer():
    """After a fast compression: the pressure falls from one to the next."""
    pressures = []
    for part in (0.3, 0.03, 0.003):
        scene = prepared({"volume_fraction": 0.87, "rate": 50.0, "relaxed": part})
        pressures.append(next(iter(simulate(scene))).numbers["pressure"])
    assert pressures[0] > pressures[1] > pressures[2] > 0.9 * pressures[1]


@pytest.mark.long
def test_slow_compression_ends_as_the_protocol_of_the_same_compression():
    """The first state of the preparation, its compression and a long rest, as moments of a protocol."""
    scene = prepared({"volume_fraction": 0.87, "relaxed": 1e-3})
    first, last = compression(scene, scene.preparation)
    start = LOOSE | {
        "cell": {"size": [1.0, 1.0], "volume_fraction": 0.75},
        "protocol": [{"time": 0.0, "scale": 1.0}, {"time": last.time, "scale": last.scale / first.scale}],
        "duration": 400.0, "frame_every": 400.0,
    }  # fmt: skip
    (*_, ours), theirs = simulate(from_plain(start)), next(iter(simulate(scene)))
    assert ours.numbers["volume_fraction"] == pytest.approx(theirs.numbers["volume_fraction"], rel=1e-12)
    assert ours.numbers["pressure"] == pytest.approx(theirs.numbers["pressure"], rel=0.02)


def closes(plain):
    """Whether films thin exponentially: surfaces that give way to the liquid, with nothing between them."""
    return plain["films"]["interface"] not in ("rigid", "half-mobile") and plain["long_range_forces"]["law"] == "none"


@pytest.mark.long
@pytest.mark.parametrize("goal", ["volume_fraction", "pressure"])
@pytest.mark.parametrize("seed", [1, 5, 15])
def test_random_packings_keep_what_every_run_keeps(seed, goal):
    """Balance, imposed stresses, symmetry and energy from time 0 on, and a run that is continued from its middle.

    Without films that close in the rest: only a repulsion keeps them open.
    """
    dice = np.random.default_rng(seed)
    drawn = iter(lambda: draw(dice), None)
    plain = next(one for one in drawn if "cell" in one and not one.get("walls") and not closes(one))
    plain = explicit(from_plain({key: plain[key] for key in plain if key != "gravity"}))
    plain["protocol"] = [{key: row[key] for key in row if key != "scale"} for row in plain["protocol"]]
    modulus, radius = plain["particles"][0]["modulus"], plain["particles"][0]["radius"][0]
    dense = len(plain["cell"]["size"]) == 2
    value = (0.85 if dense else 0.62) if goal == "volume_fraction" else 1e-4 * modulus * (radius if dense else 1.0)
    rate = 1e-5 * modulus / plain["liquid"]["viscosity"]
    scene = from_plain(plain | {"preparation": {goal: value, "rate": rate, "relaxed": 0.1}})
    frames, states = run(scene, keep=(2,))
    assert faults(scene, frames) == {}
    resumed, _ = run(scene, state=states[2])
    assert resumed[-1].numbers == frames[-1].numbers


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"preparation": {"rate": 0.1}}, r"preparation: expected either volume_fraction or pressure"),
        ({"preparation": {"rate": 0.1, "volume_fraction": 0.7}}, r"got 0\.7; expected more than the cell's 0\.75"),
        ({"preparation": {"rate": 0.1, "pressure": "10 Pa"}}, r"preparation\.pressure.*N/m"),
        (
            {"walls": [{"side": "bottom"}], "preparation": {"rate": 0.1, "pressure": 1.0}},
            r"preparation: between walls is by the wall that has a pressure; expected one of them, got 0",
        ),
        (
            {"walls": [{"side": "top", "pressure": 1.0}], "preparation": {"volume_fraction": 0.8}},
            r"preparation: to a volume fraction shortens all sides",
        ),
        (
            {"preparation": {"rate": 0.1, "pressure": 1.0}, "protocol": [{"time": 0.0}, {"time": 1.0, "scale": 0.9}]},
            r"protocol\[1\]\.scale: cannot be reached after a preparation to a pressure",
        ),
        (
            {"preparation": {"rate": 0.1, "volume_fraction": 0.8}, "protocol": [{"time": 0.0, "strain": 0.1}]},
            r"neither a strain nor a scale at time 0",
        ),
    ],
)  # fmt: skip
def test_impossible_preparations_are_refused(change, message):
    with pytest.raises(SceneError, match=message):
        from_plain(LOOSE | change)


@pytest.mark.long
def test_a_pressure_beyond_all_packings_is_refused_with_the_fraction_that_was_reached():
    scene = prepared({"pressure": "1 kN/m"})
    with pytest.raises(SceneError, match=r"preparation\.pressure: is not reached at a volume fraction of 1\.4"):
        SOFT.start(scene, SOFT.parameters(scene))


def test_check_does_not_compress_but_says_that_a_run_does():
    rows = {name: value for name, value, _ in SOFT.summary(prepared({"volume_fraction": 0.87}))}
    assert (rows["compressed to"], rows["relaxed to"]) == ("0.87", "0.01")


def test_by_default_compression_is_slow_beside_the_pressure_or_the_modulus():
    """A viscous number of 1e-3 in a layer as high as the mean diameter of 2.4 mm; or 1e-6 of modulus over viscosity."""
    rates = [
        compression_rate(scene, SOFT.parameters(scene))
        for goal in ({"pressure": "0.12 N/m"}, {"volume_fraction": 0.87}, {"volume_fraction": 0.87, "rate": 3.0})
        for scene in [prepared({"rate": None, **goal})]
    ]
    assert rates == pytest.approx([0.05, 0.05, 3.0])


def test_frames_state_how_the_preparation_ended():
    (first, *_) = simulate(prepared({"volume_fraction": 0.87, "relaxed": 0.02}))
    assert 0.0 < first.numbers["preparation_change"] <= 0.02
    assert first.numbers["preparation_time"] > np.log(0.87 / 0.75) / 2.0 / 0.1


@pytest.mark.long
def test_a_wall_compresses_a_packing_to_its_pressure_before_it_moves():
    walls = [{"side": "bottom"}, {"side": "top", "pressure": "0.05 N/m", "velocity": [1e-3, 0.0]}]
    first, *_, last = simulate(
        prepared({"pressure": "0.1 N/m", "rate": 0.3, "relaxed": 0.1}, walls=walls, duration=1.0)
    )
    width = float(np.sqrt(np.pi * 6 * (1e-6 + 1.96e-6) / 0.75))
    assert last.numbers["top_force_y"] == pytest.approx(0.05 * width, rel=1e-6)
    assert (first.numbers["top_x"], last.numbers["top_x"]) == pytest.approx((0.0, 1e-3))
    assert 0.5 * width < first.numbers["top_y"] < 0.99 * width


def test_films_that_thin_to_nothing_before_time_0_are_named_with_what_keeps_them_open():
    scene = prepared(
        {"volume_fraction": 0.87, "relaxed": 1e-6}, films={"interface": "mobile"}, long_range_forces={"law": "none"},
        rotation=False,
    )  # fmt: skip
    with pytest.raises(SceneError, match=r"preparation: at t = .*less than an atom: a long_range_forces\.law keeps"):
        SOFT.start(scene, SOFT.parameters(scene))
