"""Confined flows and drops, short and coarse; `ecume validate` holds the long ones against published numbers."""

import math

import numpy as np
import pytest

import ecume
from ecume.laws import drops, flows
from ecume.laws.kernels import kernel
from ecume.models.sph.setup.initial_particles import velocity_in
from ecume.scenes.schema import from_plain
from tests.models.sph.scenes import OPEN, PERIODIC

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]

AROUND = dict.fromkeys(("left", "right", "bottom", "top"), PERIODIC)
VISCOSITY = 0.01


def scene(**changes):
    return from_plain(
        {
            "model": "sph",
            "duration": 0.5,
            "frame_every": 0.5,
            "spacing": 0.05,
            "gravity": [0.0, 0.0],
            "liquid": {"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0, "viscosity": VISCOSITY},
            "tank": {"low": [0.0, 0.0], "high": [1.0, 1.0], **AROUND},
            "fluid": [{"low": [0.0, 0.0], "high": [1.0, 1.0]}],
            "method": {"jitter": 0.1, "shifting": "delta-plus"},
            **changes,
        }
    )


OPEN_AROUND = dict.fromkeys(("left", "right", "bottom", "top"), OPEN)


def drop(spacing=0.1, gradient=((0.5, 0.0), (0.0, -0.5)), **changes):
    """A disc of liquid that is stretched, and pulled to its center."""
    return scene(
        spacing=spacing,
        liquid={"density": 1.0, "sound_speed": 14.0, "maximum_speed": 1.4},
        tank={"low": [-3.0, -3.0], "high": [3.0, 3.0], **OPEN_AROUND},
        fluid=[{"center": [0.0, 0.0], "radius": 1.0, "velocity_gradient": gradient}],
        **{"central_force": {"angular_frequency": 1.0, "center": [0.0, 0.0]}, "method": {}, **changes},
    )


def vortices(**method):
    return scene(
        fluid=[{"low": [0.0, 0.0], "high": [1.0, 1.0], "flow": "taylor-green"}],
        method={"jitter": 0.1, **method},
    )


def last_of(case):
    (*_, last) = ecume.simulate(case)
    return last


@pytest.mark.parametrize("method", [{"shifting": "delta-plus"}, {"pressure_force": "transport"}])
def test_vortices_fade_as_they_should(method):
    last = last_of(vortices(**method))
    faded = math.exp(-flows.taylor_green_decay(2.0 * math.pi, 2.0 * math.pi, VISCOSITY) * last.time)
    x, y = 2.0 * math.pi * last.arrays["position"].T
    exact = faded * np.hypot(flows.taylor_green_velocity(x, y, 1.0), flows.taylor_green_velocity(y, x, -1.0))
    speed = np.hypot(*last.arrays["velocity"].T)
    assert np.abs(speed - exact).mean() < 0.03 * exact.mean()
    assert speed.max() == pytest.approx(faded, rel=0.03)
    assert last.numbers["kinetic_energy"] == pytest.approx(0.25 * faded**2, rel=0.04)


@pytest.mark.parametrize("width", [1.0, 2.0, 0.5])
def test_vortices_start_without_divergence_in_any_rectangle(width):
    case = scene(
        tank={"low": [0.0, 0.0], "high": [width, 1.5], **AROUND},
        fluid=[{"low": [0.0, 0.0], "high": [width, 1.5], "flow": "taylor-green"}],
        method={"jitter": 0.0},
    )
    (region,), h = case.fluid, 1e-6
    places = np.random.default_rng(0).uniform(size=(50, 2)) * [width, 1.5]
    slopes = [
        (velocity_in(region, case, places + by) - velocity_in(region, case, places - by))[:, k] / (2.0 * h)
        for k, by in enumerate(h * np.eye(2))
    ]
    assert np.abs(slopes[0]).max() > 1.0
    np.testing.assert_allclose(slopes[0], -slopes[1], rtol=0.0, atol=1e-8 * np.abs(slopes[0]).max())


def test_vortices_start_with_the_pressure_that_keeps_them():
    first = next(iter(ecume.simulate(vortices())))
    x, y = 2.0 * math.pi * first.arrays["position"].T
    exact = flows.taylor_green_pressure(x, y, 1.0, 1.0, 1.0)
    np.testing.assert_allclose(first.arrays["pressure"], exact, atol=2e-3)


def concentration_gradient(frame, smoothing):
    """The mean over all particles of what their neighbors and they weigh, over the reference density."""
    apart = frame.arrays["position"][:, None] - frame.arrays["position"][None]
    distance = np.linalg.norm(apart - np.round(apart), axis=2)
    return float((kernel("wendland-c2", 2).value(distance, smoothing) @ frame.arrays["mass"]).mean())


def test_a_full_box_that_orders_itself_thins_by_as_much_as_particles_spread():
    # Continuity goes on with the density from where it was put, the reference: but out of order particles crowd more.
    first, last = ecume.simulate(vortices(jitter=0.2))
    thinned = first.arrays["density"].mean() - last.arrays["density"].mean()
    spread = concentration_gradient(first, 0.1) - concentration_gradient(last, 0.1)
    assert spread > 2e-3
    assert thinned == pytest.approx(spread, rel=0.15)


def test_shifting_keeps_the_volume():
    still = last_of(vortices(shifting="delta-plus"))
    assert still.numbers["volume"] == pytest.approx(1.0, abs=2e-3)
    assert np.abs(still.arrays["velocity"].mean(axis=0)).max() < 1e-3


@pytest.mark.long
@pytest.mark.parametrize("walls", ["dummy", "mirror"])
@pytest.mark.parametrize("method", [{"shifting": "delta-plus"}, {"pressure_force": "transport"}])
def test_a_lid_does_not_thicken_the_liquid_that_it_drives(walls, method):
    tank = {"low": [0.0, 0.0], "high": [1.0, 1.0], "walls": walls, "top": {"velocity": [1.0, 0.0]}}
    frames = list(ecume.simulate(scene(tank=tank, method=method, duration=2.0)))
    _, settled, *_, last = (frame.numbers["volume"] for frame in frames)
    assert last == pytest.approx(settled, abs=1.5e-3)
    assert settled == pytest.approx(1.0, abs=2e-3)


def test_a_drop_swings_as_its_equation_says():
    case = drop(duration=0.6, frame_every=0.6, method={"artificial_viscosity": 0.0})
    rate, width, height, step = 0.5, 1.0, 1.0, 1e-4
    for _ in range(6000):
        change = drops.drop_strain_change(rate, 1.0, width, height)
        rate, width, height = rate + step * change, width * (1.0 + step * rate), height * (1.0 - step * rate)
    first, last = list(ecume.simulate(case))
    size = [np.sqrt((frame.arrays["position"] ** 2).mean(axis=0)) for frame in (first, last)]
    assert size[1] / size[0] == pytest.approx([width, height], rel=0.01)
    energy = [frame.numbers["total_energy"] for frame in (first, last)]
    assert energy[1] == pytest.approx(energy[0], rel=0.01)


def test_a_drop_starts_with_the_pressure_that_its_motion_needs():
    first = next(iter(ecume.simulate(drop())))
    away = np.hypot(*first.arrays["position"].T)
    np.testing.assert_allclose(first.arrays["pressure"], 0.625 * (1.0 - away**2), rtol=0.02, atol=1e-3)


def test_a_spinning_square_is_below_the_pressure_around_it():
    spun = scene(
        spacing=0.05,
        liquid={"density": 1000.0, "sound_speed": 7.0, "maximum_speed": 0.71},
        tank={"low": [-2.0, -2.0], "high": [2.0, 2.0], **OPEN_AROUND},
        fluid=[{"low": [-0.5, -0.5], "high": [0.5, 0.5], "velocity_gradient": [[0.0, 1.0], [-1.0, 0.0]]}],
        duration=0.2,
        frame_every=0.2,
        method={},
    )
    first, last = list(ecume.simulate(spun))
    middle = np.hypot(*first.arrays["position"].T) < 0.1
    assert first.arrays["pressure"][middle].mean() == pytest.approx(-147.3, rel=0.04)
    assert last.arrays["pressure"][middle].mean() == pytest.approx(-143.0, rel=0.05)
    x, v = last.arrays["position"], last.arrays["velocity"]
    spin = np.sum(last.arrays["mass"] * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]))
    assert spin == pytest.approx(-1000.0 / 6.0, rel=0.01)


@pytest.mark.parametrize("walls", ["mirror", "dummy"])
@pytest.mark.parametrize("kind", ["poiseuille", "couette"])
def test_channels_start_as_their_series_say(walls, kind):
    driven = kind == "poiseuille"
    viscosity = 0.2
    channel = scene(
        duration=0.6,
        frame_every=0.6,
        spacing=0.1,
        gravity=[8.0 * viscosity if driven else 0.0, 0.0],
        liquid={"density": 1.0, "sound_speed": 10.0, "maximum_speed": 1.0, "viscosity": viscosity},
        tank={
            "low": [0.0, 0.0],
            "high": [1.0, 1.0],
            "left": PERIODIC,
            "right": PERIODIC,
            "top": {} if driven else {"velocity": [1.0, 0.0]},
            "walls": walls,
        },
        method={},
    )
    last = last_of(channel)
    given = (last.time, 1.0, viscosity, 8.0 * viscosity if driven else 1.0)
    law = flows.poiseuille_start if driven else flows.couette_start
    exact = [law(y, *given) for y in last.arrays["position"][:, 1]]
    assert np.abs(last.arrays["velocity"][:, 0] - exact).max() < 0.035
    assert np.abs(last.arrays["velocity"][:, 1]).max() < 0.01
    assert np.ptp(last.arrays["pressure"]) < 0.1


def test_a_periodic_tank_shorter_than_a_support_is_refused():
    from ecume.errors import SceneError

    corners = {"low": [0.0, 0.0], "high": [0.4, 0.4]}
    short = scene(spacing=0.1, tank={**corners, **AROUND}, fluid=[corners])
    with pytest.raises(SceneError, match=r"periodic; expected 480 mm"):
        next(iter(ecume.simulate(short)))


def test_dummies_may_pull_where_no_liquid_can_leave_them():
    from ecume.models.sph.record import SPH

    walled = {"low": [0.0, 0.0], "high": [1.0, 1.0], "walls": "dummy"}
    assert not SPH.parameters(scene(tank=walled)).walls_clip
    assert SPH.parameters(scene(tank={**walled, "top": OPEN})).walls_clip
    assert SPH.parameters(scene(tank=walled, method={"nonnegative_wall_pressure": True})).walls_clip


def test_shifting_is_chosen_where_nothing_is_open():
    from ecume.models.sph.setup.choices import shifting_of

    walled = scene(tank={"low": [0.0, 0.0], "high": [1.0, 1.0]}, method={})
    assert shifting_of(walled) == "delta-plus"
    assert shifting_of(drop()) == "none"
    half = scene(fluid=[{"low": [0.0, 0.0], "high": [1.0, 0.5]}], method={})
    assert shifting_of(half) == "none"
