"""Contacts in frames and messages: complete lists, extremes, and the contact that ends a run."""

import contextlib
import math

import numpy as np
import pytest

from ecume.analysis.close_pairs import contact_table
from ecume.analysis.rheology import stress_tensor
from ecume.errors import BadInput, Diverged
from ecume.models.soft import SOFT
from ecume.models.soft.report.observation import Deflections, remedy, worst_contact
from ecume.simulation import simulate

from .clusters import contacts
from .test_packings import packing

pytestmark = pytest.mark.sampled(2)


def asymmetry(frame):
    """The asymmetry of the stress, over its shear component."""
    stress = stress_tensor(frame)
    return abs(stress[0, 1] - stress[1, 0]) / abs(stress[0, 1])


@pytest.mark.long
@pytest.mark.compiled
def test_the_stress_stays_symmetric_while_films_of_rotating_spheres_fade():
    frames = list(simulate(packing(count=12, strain=0.6, duration=20.0, frame_every=0.2, rotation=True)))[1:]
    listed = np.array([frame.numbers["contacts"] for frame in frames])
    assert (np.diff(listed) < 0.0).sum() > 5
    assert max(map(asymmetry, frames)) < 1e-10


VECTORS = {"films": {"output": "vectors", "cutoff": 0.9}, "rotation": True}


@pytest.mark.compiled
@pytest.mark.parametrize("dimensions", [2, 3])
def test_balance_and_stress_follow_from_the_contacts_of_a_frame(dimensions):
    filled = {2: 0.7, 3: 0.4}[dimensions]
    frame = list(simulate(packing(dimensions, filled=filled, strain=0.3, duration=20.0, count=8, **VECTORS)))[-1]
    table, numbers = contact_table(frame), frame.numbers
    assert numbers["unlisted_contacts"] == 0.0
    assert len(table.gap) == numbers["contacts"]
    total = np.zeros_like(frame.arrays["position"])
    np.add.at(total, table.pairs[:, 0], table.force)
    np.add.at(total, table.pairs[:, 1], -table.force)
    assert np.abs(total).max() < 1e-8 * np.abs(table.force).max()
    sides = np.array([numbers[name] for name in ("box_width", "box_height", "box_depth")[:dimensions]])
    between = np.diff(frame.arrays["position"][table.pairs], axis=1)[:, 0] + table.image * sides
    between[:, 0] += numbers["box_tilt"] * table.image[:, 1]
    stress = np.einsum("ca,cb->ab", table.force, between) / np.prod(sides)
    assert stress == pytest.approx(stress_tensor(frame), rel=1e-9, abs=1e-12 * np.abs(stress).max())
    assert stress == pytest.approx(stress.T, abs=1e-8 * np.abs(stress).max())
    normal = between - table.deflection
    length = np.linalg.norm(normal, axis=1)
    assert length == pytest.approx(frame.arrays["radius"][table.pairs].sum(axis=1) + table.gap, rel=1e-12)
    along = (table.deflection * normal).sum(axis=1) / length
    shear = np.linalg.norm(table.deflection - (along / length)[:, None] * normal, axis=1)
    radius = frame.arrays["radius"][table.pairs].min(axis=1)
    assert numbers["largest_deflection"] == pytest.approx((np.hypot(along, shear) / radius).max(), rel=1e-9)
    assert numbers["largest_shear_ratio"] > 0.0
    assert np.sign(numbers["pressure"]) == numbers["pressure_sign"]


@pytest.mark.compiled
def test_frames_count_the_contacts_that_they_do_not_list():
    frame = next(iter(simulate(packing(filled=0.7, films={"cutoff": 2.5}))))
    assert (frame.arrays["neighbor"] >= 0).sum() + frame.numbers["unlisted_contacts"] == frame.numbers["contacts"]
    assert frame.numbers["unlisted_contacts"] > 0.0
    with pytest.raises(BadInput, match="vectors"):
        contact_table(frame)


@pytest.mark.compiled
def test_a_run_without_a_step_names_the_contact_and_what_to_change():
    """Two spheres of the packing are pulled apart at constant gap."""
    scene = packing(films={"tension_law": "symmetric"})
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    first, second = state.pair[0]
    apart = state.position[second] - state.position[first] + state.image[0] * parameters.box[:2]
    state.position[first] -= 0.4 * apart / np.linalg.norm(apart)
    said = SOFT.diagnosis(parameters, state)
    assert f"sphere {first} with sphere" in said
    assert "radii in" in said
    assert 'films.tension_law = "gap"' in said


def is_torn(scene):
    """Whether a contact is ever deflected by more than a radius and the packing ever pulls; the run may diverge."""
    deflected = pulls = False
    with contextlib.suppress(Diverged):
        for frame in simulate(scene):
            deflected |= frame.numbers["largest_deflection"] > 1.0
            pulls |= frame.numbers["pressure"] < 0.0
            if deflected and pulls:
                return True
    return False


@pytest.mark.long
@pytest.mark.compiled
def test_the_law_that_a_message_names_lets_the_packing_flow():
    """A dense packing under the laws of the paper is torn apart, and whether the run then ends is a matter of rounding;
    under the tension law of the message it flows.
    """
    squeeze = [{"time": 0.0}, {"time": 50.0, "scale": math.sqrt(0.8 / 0.86)}, {"time": 50.0, "shear_rate": 0.01}]
    given = {"count": 30, "filled": 0.8, "protocol": squeeze, "duration": 350.0, "frame_every": 5.0}
    films = {"tangential_law": "secant", "tension_law": "symmetric"}
    fine = {"integrator": "tr-bdf2", "tolerance": 1e-3}
    assert is_torn(packing(**given, films=films, integration=fine))
    frames = list(simulate(packing(**given, films=films | {"tension_law": "gap"}, integration=fine)))
    assert frames[-1].numbers["strain"] == pytest.approx(3.0)
    assert min(frame.numbers["pressure"] for frame in frames if frame.numbers["strain"] > 0.5) > 0.0
    assert max(frame.numbers["largest_deflection"] for frame in frames) < 0.5


def beyond(normal, tangential):
    """One contact of unit spheres with these deflections."""
    line = np.ones(1)
    return Deflections(np.array([[3, -2]]), line, 0.01 * line, normal * line, tangential * line, np.zeros((1, 2)))


def test_the_remedy_depends_on_the_deflection_and_on_the_laws():
    assert "tension_law" in remedy(beyond(0.3, 0.0), contacts(tension_law="symmetric"))
    assert "tangential_law" in remedy(beyond(1e-3, 0.4), contacts(tangential_law="secant", tension_law="gap"))
    assert "volume fraction" in remedy(beyond(-0.3, 0.0), contacts(tangential_law="secant"))
    assert "tolerance" in remedy(beyond(-0.01, 0.0), contacts(tension_law="gap"))
    assert worst_contact(beyond(-0.3, 0.1)) == (
        "the largest deflection is that of sphere 3 with wall 1: gap 10 mm, normal deflection 0.3 radii in "
        "compression, tangential deflection 0.1 radii"
    )
    assert beyond(-0.3, 0.4).magnitude == pytest.approx([math.hypot(0.3, 0.4)])
