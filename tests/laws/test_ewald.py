import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j0, k0, k1

from ecume.errors import BadInput
from ecume.laws import ewald

PLACES = np.array([0.03, 0.1, 0.3, 0.8])


@pytest.mark.parametrize("eta", [1e-3, 1e-2, 0.3])
def test_short_and_smooth_part_add_up_to_k0(eta):
    for x in PLACES:
        smooth = quad(lambda k, x=x: ewald.smooth_wave(k * k, eta) * j0(k * x) * k, 0, 8 / eta**0.5, limit=400)[0]
        assert ewald.short_energy(x, eta) + smooth / (2 * np.pi) == pytest.approx(k0(x), rel=1e-9)


def test_the_short_part_is_the_defining_integral():
    for eta in (1e-2, 0.5):
        found = ewald.short_energy(0.2, eta)
        assert found == pytest.approx(0.5 * quad(lambda t: np.exp(-t - 0.01 / t) / t, 0.0, eta)[0], rel=1e-10)


@pytest.mark.parametrize("eta", [1e-3, 1e-2, 0.3])
def test_the_short_pull_is_the_slope_of_the_short_energy(eta):
    x, step = PLACES, 1e-4 * PLACES
    slope = (ewald.short_energy(x + step, eta) - ewald.short_energy(x - step, eta)) / (2 * step)
    assert ewald.short_pull(x, eta) == pytest.approx(-slope / x, rel=1e-5)


def test_near_by_the_short_pull_is_that_of_k1():
    assert ewald.short_pull(1e-3, 0.1) == pytest.approx(k1(1e-3) / 1e-3, rel=2e-5)


@pytest.mark.parametrize("eta", [1e-4, 1e-3, 1e-2])
def test_the_fit_is_as_good_as_it_says_and_stays_level_below(eta):
    upper = 2 * (7 * eta) ** 0.5
    fit = ewald.fit_short(eta, 0.1 * upper, upper)
    x = np.geomspace(0.1 * upper, upper, 77)
    found = np.array([ewald.fitted_short_pull(each**2, fit) for each in x])
    assert fit.error < 1e-7
    assert np.max(np.abs(found / ewald.short_pull(x, eta) - 1)) < fit.error + 1e-12
    assert ewald.fitted_short_pull(0.0, fit) == ewald.fitted_short_pull(fit.lower**2, fit)
    with pytest.raises(BadInput, match="expected at most"):
        ewald.fit_short(eta, 0.1 * upper, 2 * upper)


@pytest.mark.parametrize("wavenumber", [0.0, 0.7, 5.0])
def test_a_cut_wave_is_the_transform_of_k0_up_to_the_cut(wavenumber):
    cut = 2.3
    wanted = 2 * np.pi * quad(lambda x: k0(x) * j0(wavenumber * x) * x, 0.0, cut)[0]
    found = ewald.smooth_wave_within(wavenumber**2, 1e-2, cut) * np.exp(1e-2 * (1 + wavenumber**2))
    assert found == pytest.approx(wanted, rel=1e-9)


def test_the_own_energy_is_the_smooth_part_at_zero():
    wanted = quad(lambda k: ewald.smooth_wave(k * k, 0.02) * k, 0.0, 60.0)[0] / (2 * np.pi)
    assert ewald.smooth_self_energy(0.02) == pytest.approx(wanted, rel=1e-9)


def test_the_scale_of_random_charges_is_the_integral_of_k1_squared():
    wanted = 2 * np.pi * quad(lambda x: k1(x) ** 2 * x, 0.05, 40.0)[0]
    assert ewald.random_charge_force(0.05) ** 2 == pytest.approx(wanted, rel=1e-8)


def test_what_a_cut_leaves_out_is_the_integral_of_the_short_force_squared():
    eta, w = 1e-4, 5.0
    cut = 2 * (w * eta) ** 0.5
    lost = 2 * np.pi * quad(lambda x: (x * ewald.short_pull(x, eta)) ** 2 * x, cut, 3 * cut, epsabs=0)[0]
    assert ewald.short_error(w) ** 2 == pytest.approx(lost, rel=1e-3)


def test_splines_keep_long_waves_and_half_of_the_shortest():
    assert ewald.spline_share(1e-3, 4) == pytest.approx(1.0, abs=1e-12)
    assert ewald.spline_share(np.pi, 6) == pytest.approx(0.5, abs=1e-5)


def test_rounding_does_not_choose_among_fits_of_the_short_pull(monkeypatch):
    """As for K1: see `test_special`. Here all but the nearest shifts fit to rounding."""
    one, fit = ewald.fit_short(0.1, 1.1, 1.2), ewald._fit
    noise = np.random.default_rng(5)
    rounded = lambda *words: (made := fit(*words))._replace(error=made.error + 1e-15 * noise.normal())  # noqa: E731
    monkeypatch.setattr(ewald, "_fit", rounded)
    assert {ewald.fit_short(0.1, 1.1, 1.2).shift for _ in range(5)} == {one.shift}
    assert one.error < 1e-12
