"""Properties of every row of the tables of soft contacts, tested through the code of contacts."""

import inspect
import math

import numpy as np
import pytest

from ecume.laws.friction import FRICTIONS
from ecume.laws.interfaces import INTERFACES
from ecume.laws.long_range import REMOTE
from ecume.laws.soft_contacts import TENSION
from ecume.laws.soft_pair import Prefactors
from ecume.laws.surfaces import SURFACES, Body
from ecume.models import MODELS
from ecume.models.soft.contacts.contact import (
    contact_energy,
    contact_gap_energy,
    film_of,
    gap_energy_of,
    normal_energy,
    remote_force_and_slope,
)
from ecume.models.soft.integration.linear_solvers import begin_step
from ecume.models.soft.protocol import drive_at
from ecume.models.soft.report.energy_budget import elastic_energy
from ecume.scenes.schema import from_plain

SOFT = MODELS["soft"]
BODY = Body(2.0, 0.5, 1.0, 0.0, 0.0)
GAP, STRETCH, SHEAR = 0.03, -0.01, 0.002
pytestmark = pytest.mark.compiled


def scene_of(films=(), remote=(), x=2.03):
    """Two spheres in contact."""
    spheres = [{"radius": 1.0, "modulus": 1.0, "positions": [[place, 0.0]]} for place in (0.0, x)]
    return from_plain({
        "model": "soft", "duration": 1.0, "frame_every": 1.0, "particles": spheres, "films": dict(films),
        "liquid": {"viscosity": 0.1, "surface_tension": 0.3}, "long_range_forces": dict(remote),
    })  # fmt: skip


def contacts_of(**given):
    return SOFT.parameters(scene_of(**given)).contacts


def film(contacts):
    """The compiled contact."""
    return film_of(contacts, BODY, math.log(GAP), BODY.radius_sum + GAP + STRETCH, SHEAR)


def asked(law, contacts, **known):
    """A law of a table with the constants of a scene."""
    return law(*(known.get(name, getattr(contacts, name, None)) for name in inspect.signature(law).parameters))


@pytest.mark.long
@pytest.mark.parametrize("name", SURFACES)
def test_a_contact_yields_by_the_surface_that_was_asked_for(name):
    contacts = contacts_of(films={"surface": name})
    known = {"body": BODY, "gap": GAP, "stretch": STRETCH, "prefactors": Prefactors()}
    wanted, found = asked(SURFACES[name].surface, contacts, **known), film(contacts).surface
    whole = asked(SURFACES[name].surface, contacts, **{**known, "stretch": math.hypot(STRETCH, SHEAR)})
    assert found.size == pytest.approx(wanted.size, rel=1e-12)
    assert (found.normal, found.tangential) == pytest.approx((whole.normal, whole.tangential), rel=1e-12)
    assert normal_energy(contacts, BODY, GAP, STRETCH) == pytest.approx(asked(SURFACES[name].energy, contacts, **known))


@pytest.mark.parametrize("name", SURFACES)
def test_a_normal_force_is_the_slope_of_its_energy(name):
    contacts, fine = contacts_of(films={"surface": name}), 1e-6
    for stretch in (-0.02, -0.004, 0.004, 0.02):
        surface = film_of(contacts, BODY, math.log(GAP), BODY.radius_sum + GAP + stretch, 0.0).surface
        slope = np.diff([normal_energy(contacts, BODY, GAP, stretch + way) for way in (-fine, fine)])[0] / (2 * fine)
        assert surface.normal * stretch == pytest.approx(slope, rel=1e-6)
        energies = [normal_energy(contacts, BODY, GAP * math.exp(way), stretch) for way in (-1e-5, 1e-5)]
        assert gap_energy_of(contacts, BODY, GAP, stretch) == pytest.approx(np.diff(energies)[0] / 2e-5, rel=1e-5)


@pytest.mark.parametrize("tension", TENSION)
@pytest.mark.parametrize("name", SURFACES)
def test_both_forces_are_the_slopes_of_one_energy(name, tension):
    contacts, fine = contacts_of(films={"surface": name, "tension_law": tension, "cavitation_pressure": 1.0}), 1e-6

    def energy(gap, stretch, shear):
        return contact_energy(contacts, BODY, gap, stretch, shear**2)

    for stretch in (-0.02, 0.01):
        surface = film_of(contacts, BODY, math.log(GAP), BODY.radius_sum + GAP + stretch, 0.015).surface
        ends = [energy(GAP, stretch + way, 0.015) for way in (-fine, fine)]
        assert surface.normal * stretch == pytest.approx(np.diff(ends)[0] / (2 * fine), rel=1e-6)
        ends = [energy(GAP, stretch, 0.015 + way) for way in (-fine, fine)]
        assert surface.tangential * 0.015 == pytest.approx(np.diff(ends)[0] / (2 * fine), rel=1e-6)
        ends = [energy(GAP * math.exp(way), stretch, 0.015) for way in (-1e-5, 1e-5)]
        found = contact_gap_energy(contacts, BODY, GAP, stretch, 0.015**2)
        assert found == pytest.approx(np.diff(ends)[0] / 2e-5, rel=1e-5)


@pytest.mark.parametrize("name", SURFACES)
def test_a_step_pulls_at_spheres_with_minus_the_gradient_of_the_energy_that_frames_report(name):
    parameters = SOFT.parameters(scene_of(films={"surface": name}))
    state = SOFT.start(scene_of(films={"surface": name}), parameters)
    step, found = SOFT.workspace(parameters, state, 1.0).step, []
    for x in (2.03 - 0.01 - 1e-6, 2.03 - 0.01 + 1e-6, 2.03 - 0.01):
        step.bodies.before[1, 0] = x
        begin_step(parameters, step, drive_at(parameters.protocol, 0.0))
        found.append(elastic_energy(parameters.contacts, step))
    assert found[2] > 0.0
    assert step.responses.force[0, 0] == pytest.approx((found[1] - found[0]) / 2e-6, rel=1e-6)
    assert step.bodies.right[:, 0] == pytest.approx([step.responses.force[0, 0], -step.responses.force[0, 0]])


@pytest.mark.parametrize("name", INTERFACES)
def test_a_film_resists_by_the_interface_that_was_asked_for(name):
    contacts = contacts_of(films={"interface": name, "viscosity_ratio": 0.5})
    made = film(contacts)
    known = {
        "contact_size": made.surface.size,
        "gap": GAP,
        "film_prefactors": (contacts.squeeze, contacts.shear),
        "compression": -made.surface.normal * STRETCH,
        "slip_force": made.held * made.surface.tangential * SHEAR,
        "body": BODY,
    }
    assert tuple(made.resistance) == pytest.approx(tuple(asked(INTERFACES[name], contacts, **known)), rel=1e-12)


@pytest.mark.parametrize("name", FRICTIONS)
def test_tips_hold_by_the_friction_that_was_asked_for(name):
    contacts = contacts_of(
        films={"friction": name, "friction_coefficient": 0.02, "roughness": 0.05, "critical_load": 1e-5}
    )
    made = film(contacts)
    pull, compression = made.surface.tangential * SHEAR, -made.surface.normal * STRETCH
    wanted = asked(FRICTIONS[name].rubbing, contacts, gap=GAP, compression=compression, pull=pull)
    found = (made.held, made.slide_by_pull, made.slide_by_limit, made.limit_by_normal, made.limit_by_gap)
    assert found == pytest.approx(tuple(wanted), rel=1e-12)
    assert (made.held == 1.0) == (name == "none")


@pytest.mark.parametrize("name", REMOTE)
def test_what_acts_across_a_film_is_the_law_that_was_asked_for(name):
    given = {
        "law": name,
        "steric_strength": 0.02,
        "steric_length": 0.04,
        "hamaker_constant": 1e-3,
        "double_layer_strength": 1e-2,
        "debye_length": 0.05,
    }
    contacts, law = contacts_of(remote=given), REMOTE[name]
    force, slope = remote_force_and_slope(GAP, 0.5, contacts)
    known = {"gap": GAP, "reduced_radius": 0.5}
    assert force == pytest.approx(asked(law.force, contacts, **known), rel=1e-12)
    assert slope == pytest.approx(asked(law.slope, contacts, **known), rel=1e-12)
    assert (force != 0.0) == law.acts
    fine = 1e-7
    energies = [asked(law.energy, contacts, gap=GAP + way, reduced_radius=0.5) for way in (-fine, fine)]
    assert force == pytest.approx(-np.diff(energies)[0] / (2 * fine), rel=1e-6)
    made = film(contacts)
    assert (made.remote_force, made.remote_slope) == pytest.approx((force, slope), rel=1e-12)
