"""Film, surface and remote forces of soft spheres, and the exact motions of two of them."""

import math

import pytest
from scipy.integrate import quad, solve_ivp
from tests.oracles.soft_contacts import deflection_under_force, gap_speed, relaxation_passage

from ecume.errors import BadInput
from ecume.laws.long_range import REMOTE
from ecume.laws.soft_pair import (
    PREFACTORS,
    Prefactors,
    SoftPair,
    contact_size,
    crossover_gap,
    gap_energy,
    optimal_force,
    pair_modulus,
    passage_time,
    reduced_radius,
    shear_friction,
    size_under_force,
    squeeze_friction,
    surface_energy,
    surface_force,
    viscous_time,
)

BODY = {"gap": 0.013, "reduced_radius": 0.7, "modulus": 4.0}
CHOICES = {**PREFACTORS, "lopsided": Prefactors(2.0, 3.0, 0.5, 0.7, 1.3, 0.4)}
SAMPLES = {"none": (), "steric": (2.0, 0.03), "dlvo": (0.7, 0.004, 0.6, 0.02, 5e-4)}
each_choice = pytest.mark.parametrize("prefactors", CHOICES.values(), ids=CHOICES)


def slope(function, at, by=1e-6):
    return (function(at * (1 + by)) - function(at * (1 - by))) / (2 * by * at)


def test_rigid_spheres_are_squeezed_against_the_lubrication_force():
    radius, gap, viscosity = 0.8, 1e-3, 2.0
    reduced = reduced_radius(radius, radius)
    rigid = contact_size(reduced, gap, 0.0, 1.0, 1.0)
    assert squeeze_friction(rigid, gap, viscosity) == pytest.approx(6 * math.pi * viscosity * reduced**2 / gap)


def test_a_wall_doubles_the_reduced_radius_and_quadruples_the_squeeze():
    spheres, wall = (contact_size(reduced_radius(1.0, other), 1e-3, 0.0, 1.0, 1.0) for other in (1.0, math.inf))
    assert squeeze_friction(wall, 1e-3, 1.0) == pytest.approx(6 * math.pi / 1e-3)
    assert squeeze_friction(wall, 1e-3, 1.0) == pytest.approx(4 * squeeze_friction(spheres, 1e-3, 1.0))


def test_a_thin_film_slides_more_easily_than_it_is_squeezed():
    ratio = shear_friction(0.1, 1e-3, 1.0) / squeeze_friction(0.1, 1e-3, 1.0)
    assert ratio == pytest.approx(2 / 3 * (1e-3 / 0.1) ** 2)


def test_the_physical_prefactors_give_hertz_contact_of_incompressible_spheres():
    radius, modulus, compression, poisson = 0.8, 5.0, 0.01, 0.5
    effective = modulus / (2 * (1 - poisson**2))
    hertz = 4 / 3 * effective * math.sqrt(radius / 2) * compression**1.5
    body = {"gap": 1e-12, "reduced_radius": radius / 2, "modulus": modulus}
    assert surface_force(compression, **body, prefactors=PREFACTORS["physical"]) == pytest.approx(hertz, rel=1e-9)


@each_choice
@pytest.mark.parametrize("compression", [1e-7, 1.3e-5, 4e-3, 0.5])
def test_the_force_is_the_slope_of_the_energy(prefactors, compression):
    energy = slope(lambda x: surface_energy(x, **BODY, prefactors=prefactors), compression)
    assert surface_force(compression, **BODY, prefactors=prefactors) == pytest.approx(energy, rel=1e-8)


@pytest.mark.parametrize("compression", [-0.4, 1e-5, 0.02])
@each_choice
def test_what_a_gap_does_to_the_energy_of_a_held_deflection_is_its_slope(prefactors, compression):
    """A quarter of k delta^2 at a wide gap, where the stiffness goes as the root of the gap."""
    by_gap = slope(lambda gap: surface_energy(compression, **{**BODY, "gap": gap}, prefactors=prefactors), BODY["gap"])
    film = prefactors.gap_weight * BODY["gap"]
    stiffness = prefactors.normal * BODY["modulus"] * math.sqrt(2.0 * BODY["reduced_radius"] * film)
    found = gap_energy(compression, stiffness, prefactors.deflection_weight * abs(compression) / film)
    assert found == pytest.approx(by_gap * BODY["gap"], rel=1e-6)
    assert gap_energy(compression, stiffness, 0.0) == pytest.approx(0.25 * stiffness * compression**2)


def test_compression_repels_and_tension_pulls_as_much():
    forces = [surface_force(x, **BODY, prefactors=Prefactors()) for x in (0.02, -0.02)]
    assert forces[0] == -forces[1] > 0
    energies = [surface_energy(x, **BODY, prefactors=Prefactors()) for x in (0.02, -0.02, 0.0)]
    assert energies[0] == energies[1] > energies[2] == 0


def test_a_small_and_soft_partner_counts_more_than_a_large_and_stiff_one():
    assert reduced_radius(1.0, 4.0) == reduced_radius(4.0, 1.0) == pytest.approx(0.8)
    assert pair_modulus(1.0, 4.0) == pair_modulus(4.0, 1.0) == pytest.approx(1.6)


@pytest.mark.parametrize("name", REMOTE)
@pytest.mark.parametrize("gap", [0.004, 0.011, 0.029, 0.3])
def test_a_remote_force_is_minus_the_slope_of_its_energy(name, gap):
    law, given = REMOTE[name], SAMPLES[name]
    force = law.force(gap, *given)
    assert force == pytest.approx(-slope(lambda h: law.energy(h, *given), gap), rel=1e-7, abs=1e-9)
    assert law.slope(gap, *given) == pytest.approx(slope(lambda h: law.force(h, *given), gap), rel=1e-7, abs=1e-7)


def test_steric_layers_repel_within_their_length_only():
    force = REMOTE["steric"].force
    assert force(0.5, 1.0, 1.0) > force(0.9, 1.0, 1.0) > force(1.0, 1.0, 1.0) == force(2.0, 1.0, 1.0) == 0.0


def test_dlvo_attracts_close_by_repels_further_off_and_fades():
    force = REMOTE["dlvo"].force
    assert force(0.001, *SAMPLES["dlvo"]) < 0 < force(0.02, *SAMPLES["dlvo"])
    assert abs(force(1.0, *SAMPLES["dlvo"])) < 1e-2 * force(0.02, *SAMPLES["dlvo"])


def pair_of(prefactors=PREFACTORS["paper"], kappa=1e-3):
    return SoftPair(radius=0.7, modulus=1.3 / (kappa * 0.49), viscosity=0.4, prefactors=prefactors)


@each_choice
@pytest.mark.parametrize(("gap_from", "gap_to"), [(1e-4, 3e-4), (0.002, 0.5), (0.3, 0.01)])
def test_a_passage_takes_the_integral_of_the_slowness(prefactors, gap_from, gap_to):
    pair = pair_of(prefactors)
    slowness, _ = quad(
        lambda q: math.exp(q) / gap_speed(pair, math.exp(q), 1.3), *sorted(map(math.log, (gap_from, gap_to))),
        epsrel=1e-11,
    )  # fmt: skip
    assert passage_time(pair, 1.3, gap_from, gap_to) == pytest.approx(slowness, rel=1e-9)


@each_choice
def test_size_and_deflection_under_a_force_are_those_of_the_laws(prefactors):
    pair = pair_of(prefactors)
    deflection = deflection_under_force(pair, 0.02, -1.3)
    size = contact_size(pair.radius / 2, 0.02, deflection, prefactors.gap_weight, prefactors.deflection_weight)
    assert deflection < 0
    assert size_under_force(pair, 0.02, -1.3) == pytest.approx(size, rel=1e-12)
    body = {"gap": 0.02, "reduced_radius": pair.radius / 2, "modulus": pair.modulus, "prefactors": prefactors}
    assert surface_force(deflection, **body) == pytest.approx(-1.3, rel=1e-12)


def test_wide_gaps_open_by_e_in_the_viscous_time_and_narrow_ones_slower_when_pulled_harder():
    soft, hard = pair_of(kappa=1e-2), pair_of(kappa=1e-9)
    assert passage_time(hard, 1.3, 0.1, 0.1 * math.e) == pytest.approx(viscous_time(hard, 1.3), rel=1e-4)
    wide, narrow = 1e3 * crossover_gap(soft, 1.3), 1e-3 * crossover_gap(soft, 1.3)
    assert passage_time(soft, 2.6, wide, 2 * wide) < passage_time(soft, 1.3, wide, 2 * wide)
    assert passage_time(soft, 2.6, narrow, 2 * narrow) > passage_time(soft, 1.3, narrow, 2 * narrow)


@each_choice
def test_no_force_moves_a_gap_faster_than_the_optimal_one(prefactors):
    pair = pair_of(prefactors)
    best = optimal_force(pair, 0.02)
    speeds = [gap_speed(pair, 0.02, factor * best) for factor in (0.99, 1.0, 1.01)]
    assert speeds[1] > max(speeds[0], speeds[2])


def test_tension_relaxes_as_the_equation_of_motion_says():
    pair, clearance = pair_of(Prefactors(2.0, 3.0, 0.5, 0.7, 1.3, 1.3)), 0.05

    def rate(_, deflection):
        gap = clearance - deflection[0]
        size = contact_size(pair.radius / 2, gap, deflection[0], 1.3, 1.3)
        return [-0.5 * pair.modulus * size * deflection[0] / squeeze_friction(size, gap, pair.viscosity, 2.0)]

    until = relaxation_passage(pair, clearance, 0.04, 0.003)
    end = solve_ivp(rate, (0, until), [0.04], method="Radau", rtol=1e-10, atol=1e-14).y[0, -1]
    assert end == pytest.approx(0.003, rel=1e-7)


def test_what_has_no_closed_form_or_no_gap_is_refused():
    with pytest.raises(BadInput, match="closed form"):
        relaxation_passage(pair_of(PREFACTORS["physical"]), 0.05, 0.04, 0.03)
    with pytest.raises(BadInput, match="gap_to"):
        passage_time(pair_of(), 1.0, 0.1, 0.0)
