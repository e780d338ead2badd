"""Moduli of models that are solved by hand, steady flows with known means, and stresses put together again."""

import math

import numpy as np
import pytest

from ecume.analysis.rheology import (
    flow_point,
    moduli,
    normal_stress_differences,
    shear_rates,
    stress_tensor,
    viscous_number,
)
from ecume.analysis.series import steady_mean
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
