"""Moduli of models with closed-form solutions, steady flows with known means, and sums of stress contributions."""

import math

import numpy as np
import pytest

from ecume.analysis.rheology import (
    creep_flow,
    flow_point,
    herschel_bulkley,
    mean_stress,
    moduli,
    normal_stress_differences,
    over_seeds,
    power_fit,
    shear_rates,
    steady_part,
    steady_state,
    stress_tensor,
    viscosity_divergence,
    viscous_number,
)
from ecume.analysis.series import Mean, steady_mean
from ecume.errors import BadInput
from ecume.trajectories.frame import Frame


def maxwell(modulus, relaxation, frequency):
    """G' and G'' of a spring and a dashpot in series."""
    product = relaxation * frequency
    return modulus * product**2 / (1 + product**2), modulus * product / (1 + product**2)


@pytest.mark.parametrize("relaxation", [0.05, 0.3, 4.0])
def test_the_moduli_of_a_maxwell_element(relaxation):
    frequency, time = 2.0, np.linspace(0.0, 30.0, 3001)
    phase = frequency * time
    storage, loss = maxwell(7.0, relaxation, frequency)
    strain = 0.01 * np.sin(phase + 0.7)
    stress = 0.01 * (storage * np.sin(phase + 0.7) + loss * np.cos(phase + 0.7)) + 1e-3 * np.exp(-5.0 * time)
    found = moduli(time, strain, stress + 0.2 + 0.003 * time, 2 * math.pi / frequency)
    assert found.storage.value == pytest.approx(storage, rel=1e-3)
    assert found.loss.value == pytest.approx(loss, rel=1e-3)
    assert (found.periods, found.amplitude) == (9, pytest.approx(0.01, rel=1e-4))
    assert found.overtone < 1e-3


def test_a_triangle_of_strain_gives_the_same_moduli_of_a_dashpot_and_spring_in_parallel():
    period, time = 0.8, np.linspace(0.0, 4.0, 8001) + 1.3e-4  # no instant on a jump of the rate
    strain = 2.0 / math.pi * np.arcsin(np.sin(2 * math.pi * time / period))
    rate = 4.0 / period * np.sign(np.cos(2 * math.pi * time / period))
    found = moduli(time, strain, 3.0 * strain + 0.5 * rate, period)
    assert found.storage.value == pytest.approx(3.0, rel=2e-3)
    assert found.loss.value == pytest.approx(0.5 * 2 * math.pi / period, rel=2e-3)
    assert found.amplitude == pytest.approx(8 / math.pi**2, rel=1e-3)


def test_noise_shows_in_the_errors_as_large_as_it_is():
    random, time = np.random.default_rng(1), np.linspace(0.0, 10.0, 2001)
    wave = np.sin(2 * math.pi * time)
    found = [moduli(time, wave, 5.0 * wave + random.normal(size=2001), 1.0) for _ in range(40)]
    for name, wanted in (("storage", 5.0), ("loss", 0.0)):
        values = np.array([getattr(one, name).value for one in found])
        errors = np.array([getattr(one, name).error for one in found])
        assert values.mean() == pytest.approx(wanted, abs=4 * values.std() / math.sqrt(40))
        assert errors.mean() == pytest.approx(values.std(), rel=0.4)
    single = moduli(time[:202], wave[:202], 5.0 * wave[:202] + random.normal(size=202), 1.0)
    assert single.storage.error == pytest.approx(math.sqrt(2.0 / 200), rel=0.3)


def test_a_cubic_answer_shows_as_an_overtone():
    time = np.linspace(0.0, 4.0, 801)
    wave = np.sin(2 * math.pi * time)
    assert moduli(time, wave, wave**3, 1.0).overtone == pytest.approx(1 / 3, rel=1e-6)


@pytest.mark.parametrize("start", [0.0, 0.3, 1.9])
@pytest.mark.parametrize(("spring", "dashpot"), [(0.2, 0.0), (-0.1, 0.3), (0.5, -0.2)])
def test_cubic_springs_and_dashpots_stiffen_and_thicken(start, spring, dashpot):
    """x^3 = (3 T_1(x) + T_3(x))/4, of the strain and of the rate over their amplitudes."""
    time = np.linspace(0.0, 4.0, 801)
    strain, rate = np.sin(2 * math.pi * time + start), np.cos(2 * math.pi * time + start)
    stress = 2.0 * strain + spring * strain**3 + rate + dashpot * rate**3
    found = moduli(time, 0.5 * strain, stress, 1.0)
    assert found.elastic_third == pytest.approx(0.25 * spring / (2.0 + 0.75 * spring), abs=1e-9)
    assert found.viscous_third == pytest.approx(0.25 * dashpot / (1.0 + 0.75 * dashpot), abs=1e-9)


def test_too_little_of_an_oscillation_is_refused():
    time = np.linspace(0.0, 1.0, 50)
    with pytest.raises(BadInput, match="whole period"):
        moduli(time, time, time, 2.0)
    with pytest.raises(BadInput, match="10 instants"):
        moduli(time[::10], time[::10], time[::10], 0.5)


def flow(shear=2.0, normal=5.0, rate=0.3, noise=0.0, count=400):
    random = np.random.default_rng(3)
    return [
        Frame(
            0.1 * step, {"position": np.zeros((1, 2))},
            {"strain": rate * 0.1 * step, "shear_stress": shear + noise * random.normal(),
             "normal_stress": normal + noise * random.normal(), "volume_fraction": 0.8}, {},
        )
        for step in range(count)
    ]  # fmt: skip


def test_a_steady_flow_has_a_friction_a_viscous_number_and_a_viscosity():
    point = flow_point(flow(noise=0.2), viscosity=0.1)
    assert point.friction.value == pytest.approx(0.4, abs=4 * point.friction.error)
    assert 0.0 < point.friction.error < 0.01
    assert point.viscous_number.value == pytest.approx(viscous_number(0.1, 0.3, 5.0), rel=0.02)
    assert point.viscosity == pytest.approx(2.0 / 0.3, rel=0.02)
    assert point.fraction.value == pytest.approx(0.8)


def test_shear_to_the_other_side_has_the_same_friction():
    point = flow_point(flow(shear=-2.0, rate=-0.3), viscosity=0.1)
    assert (point.friction.value, point.viscous_number.value) == (pytest.approx(0.4), pytest.approx(0.006))


def test_a_flow_under_tension_has_no_friction():
    with pytest.raises(BadInput, match="a tension"):
        flow_point(flow(normal=-1.0), viscosity=0.1)
    with pytest.raises(BadInput, match="two frames"):
        shear_rates(flow(count=1))


def test_block_means_see_through_what_neighbors_share():
    random = np.random.default_rng(1)
    values = np.repeat(random.normal(size=400), 50)
    assert steady_mean(values).error == pytest.approx(1 / math.sqrt(400), rel=0.8)
    assert steady_mean(values).error > 3 * values.std() / math.sqrt(len(values))
    assert math.isnan(steady_mean(np.ones(1)).error)


def test_a_stress_is_the_sum_of_its_parts():
    tensor = {"xx": 4.0, "xy": 2.0, "xz": 0.5, "yx": 1.0, "yy": 1.0, "yz": 3.0, "zx": 0.5, "zy": 3.0, "zz": -1.0}
    parts = {"squeeze": 1.0, "sliding": 0.1, "remote": -0.5}
    numbers = {f"stress_{part}_{axes}": scale * tensor[axes] for part, scale in parts.items() for axes in tensor}
    frame = Frame(0.0, {"position": np.zeros((2, 3))}, numbers, {})
    total = stress_tensor(frame)
    assert total == pytest.approx(0.6 * np.array([[4.0, 2.0, 0.5], [1.0, 1.0, 3.0], [0.5, 3.0, -1.0]]))
    assert sum(stress_tensor(frame, part) for part in ("squeeze", "sliding", "remote")) == pytest.approx(total)
    assert normal_stress_differences(frame) == pytest.approx((1.8, 1.2))
    with pytest.raises(BadInput, match="squeeze, sliding, remote"):
        stress_tensor(frame, "elastic")


def test_a_transient_is_cut_and_a_drift_is_no_steady_state():
    noise, step = np.random.default_rng(1).normal(size=(40, 400)), np.arange(400)
    found = [steady_state(5.0 + 20.0 * np.exp(-step / 20.0) + row) for row in noise]
    assert all(60 <= one.first <= 266 for one in found)
    assert sum(one.settled for one in found) >= 36
    values = np.array([one.mean.value for one in found])
    errors = np.array([one.mean.error for one in found])
    assert (np.abs(values - 5.0) < 4.0 * errors).mean() > 0.9
    assert values.mean() == pytest.approx(5.0, abs=0.03)
    assert not any(steady_state(0.02 * step + row).settled for row in noise)
    assert steady_state(np.full(40, 0.1)).settled


def test_the_later_of_two_transients_decides():
    frames = [
        frame._replace(
            numbers=frame.numbers | {"normal_stress": frame.numbers["normal_stress"] + 9 * math.exp(-n / 15)}
        )
        for n, frame in enumerate(flow(noise=0.02))
    ]
    steady, settled = steady_part(frames)
    assert settled
    assert 130 <= len(steady) < 320


def test_mean_stresses_have_the_errors_of_their_fluctuations():
    random, frames = np.random.default_rng(2), []
    for time in range(800):
        xx, yy, zz = np.array([-7.0, -4.0, -1.0]) + random.normal(size=3)
        tensor = {"xx": xx, "yy": yy, "zz": zz, "xy": 2.0 + random.normal()}
        tensor |= dict.fromkeys(("xz", "yx", "yz", "zx", "zy"), 0.0)
        numbers = {f"stress_squeeze_{axes}": value for axes, value in tensor.items()}
        frames.append(Frame(float(time), {"position": np.zeros((1, 3))}, numbers, {}))
    found = mean_stress(frames)
    wanted = {"shear": (2.0, 1.0), "pressure": (4.0, 3**-0.5), "first_difference": (-3.0, 2**0.5)}
    for name, (value, spread) in (wanted | {"second_difference": (-3.0, 2**0.5)}).items():
        mean = getattr(found, name)
        assert mean.value == pytest.approx(value, abs=4.0 * spread / math.sqrt(800))
        assert mean.error == pytest.approx(spread / math.sqrt(800), rel=0.6)


def test_a_fitted_yield_stress_lies_within_its_error_of_the_true_one():
    random, rates = np.random.default_rng(3), np.geomspace(1e-2, 1e3, 9) * 3.0
    exact = 3.0 + 0.7 * rates**0.45
    fits = [
        herschel_bulkley(-rates, [Mean(s + 0.02 * s * random.normal(), 0.02 * s) for s in exact]) for _ in range(60)
    ]
    for name, wanted in (("offset", 3.0), ("factor", 0.7), ("exponent", 0.45)):
        values, errors = np.array([getattr(one, name) for one in fits]).T
        assert np.abs((values - wanted) / errors).mean() < 1.3
        assert errors.mean() == pytest.approx(values.std(), rel=0.45)
    assert np.mean([one.misfit for one in fits]) == pytest.approx(1.0, abs=0.3)
    assert fits[0](rates) == pytest.approx(exact, rel=0.05)


def test_points_without_errors_have_those_of_their_scatter():
    random, x = np.random.default_rng(4), np.geomspace(0.1, 10.0, 30)
    fit = power_fit(x, [Mean(1.0 + 2.0 * one**0.5 + 0.05 * random.normal(), math.nan) for one in x])
    assert fit.exponent.value == pytest.approx(0.5, abs=4.0 * fit.exponent.error)
    assert 0.005 < fit.exponent.error < 0.1


def test_where_a_viscosity_diverges():
    phi, random = np.linspace(0.3, 0.6, 9), np.random.default_rng(5)
    exact = 2.0 * (1.0 - phi / 0.64) ** -1.8
    found = viscosity_divergence(phi, [Mean(value * (1.0 + 0.01 * random.normal()), 0.01 * value) for value in exact])
    assert found.fraction.value == pytest.approx(0.64, abs=4.0 * found.fraction.error)
    assert found.exponent.value == pytest.approx(1.8, abs=4.0 * found.exponent.error)
    assert found.factor.value == pytest.approx(2.0, abs=4.0 * found.factor.error)
    assert 0.0 < found.fraction.error < 0.02


def test_fits_of_too_little_are_refused():
    with pytest.raises(BadInput, match="4 points"):
        power_fit(np.array([1.0, 2.0, 3.0]), [Mean(1.0, 0.1)] * 3)
    with pytest.raises(BadInput, match="positive arguments"):
        power_fit(np.array([0.0, 1.0, 2.0, 3.0]), [Mean(1.0, 0.1)] * 4)
    with pytest.raises(BadInput, match="do not determine"):
        power_fit(np.array([1.0, 2.0, 3.0, 4.0]), [Mean(x, 0.1) for x in np.exp([1.0, 2.0, 3.0, 40.0])])


def test_the_error_of_seeds_is_that_of_their_scatter():
    random = np.random.default_rng(6)
    found = over_seeds([Mean(value, 1e-3) for value in random.normal(size=400)])
    assert found.error == pytest.approx(1 / math.sqrt(400), rel=0.15)
    assert over_seeds([Mean(2.0, 0.3)]) == Mean(2.0, 0.3)
    with pytest.raises(BadInput, match="one run"):
        over_seeds([])


def creeping(strain):
    return [Frame(time, {}, {"strain": strain(max(time - 2.0, 0.0))}, {}) for time in np.linspace(0.0, 42.0, 421)]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_creep_that_flows_and_creep_that_stops(sign):
    flows = creep_flow(creeping(lambda since: sign * (0.03 * since + 0.1 * (1.0 - math.exp(-since)))), 2.0)
    assert flows.flows
    assert flows.rate.value == pytest.approx(0.03, rel=1e-3)
    assert flows.strain == pytest.approx(1.3)
    stops = creep_flow(creeping(lambda since: sign * 0.1 * math.log1p(since)), 2.0)
    assert not stops.flows
    assert stops.slowing == pytest.approx(1.0, abs=0.05)
    assert not creep_flow(creeping(lambda since: -0.01 * since * (since < 5.0)), 2.0).flows
