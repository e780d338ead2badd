"""Reflected Brownian motion: the equilibrium in front of a wall is preserved for any time step."""

import numpy as np
import pytest

from ecume.laws.brownian_motion import reflected_gain

COUNT = 40_000


@pytest.mark.parametrize("spread", [0.05, 0.3, 2.0])
def test_a_settling_layer_stays_a_settling_layer_from_contact_on(spread):
    # In lengths of the layer D/v: a step with the standard deviation s drifts by s^2/2 toward the wall.
    dice = np.random.default_rng(3)
    start = dice.exponential(size=COUNT)
    change = spread * dice.normal(size=COUNT) - 0.5 * spread**2
    least = np.array(
        [reflected_gain(d, spread**2, e) for d, e in zip(change, dice.exponential(size=COUNT), strict=True)]
    )
    end = np.maximum(start + change, least)
    assert end.min() > 0.0
    for quantile in (0.01, 0.05, 0.2, 0.5, 0.9):
        share = np.mean(end < -np.log1p(-quantile))
        assert share == pytest.approx(quantile, abs=4.0 * np.sqrt(quantile * (1.0 - quantile) / COUNT))
