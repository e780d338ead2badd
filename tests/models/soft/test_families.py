"""Alternatives in scenes: surfaces, interfaces, contact friction; and unequal spheres."""

import dataclasses
import inspect
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ecume.errors import SceneError
from ecume.laws.interfaces import INTERFACES
from ecume.laws.soft_pair import SoftPair, contact_size, pair_modulus, passage_time, reduced_radius
from ecume.laws.surfaces import SURFACES, Body
from ecume.models.soft import SOFT
from ecume.models.soft.state import ACCEPTED, FAILED
from ecume.scenes.schema import from_plain, to_plain
from ecume.scenes.soft import FilmSpec
from ecume.simulation import simulate
from tests.oracles.soft_contacts import deflection_under_force

from .clusters import integrated

pytestmark = [pytest.mark.compiled, pytest.mark.sampled(2)]


def pair(force=(-1e-3, 0.0), gap=0.02, radii=(1.0, 1.0), moduli=(1.0, 1.0), duration=50.0, **more):
    """Two spheres; the force acts on the second one, and its opposite on the first."""
    centers = (0.0, sum(radii) + gap)
    spheres = [
        {"radius": r, "modulus": e, "positions": [[x, 0.0]], "force": [sign * one for one in force]}
        for r, e, x, sign in zip(radii, moduli, centers, (-1.0, 1.0), strict=True)
    ]
    plain = {
        "model": "soft", "duration": duration, "frame_every": duration, "particles": spheres,
        "liquid": {"viscosity": 0.1, "surface_tension": 0.3}, "integration": {"tolerance": 1e-8},
    }  # fmt: skip
    return from_plain(plain | more)


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize("push", [-2e-3, 2e-3])
def test_a_gap_moves_as_the_laws_of_film_and_surface_say(surface, interface, push):
    films = {"surface": surface, "interface": interface, "viscosity_ratio": 0.5}
    _, state = integrated(pair((push, 0.0), radii=(1.0, 0.6), duration=30.0, films=films))
    reduced, law = reduced_radius(1.0, 0.6), INTERFACES[interface]
    known = {
        "viscosity": 0.1, "viscosity_ratio": 0.5, "film_prefactors": (1.5 * math.pi, math.pi), "gap_weight": 1.0,
        "compression": -push, "slip_force": 0.0, "body": Body(1.6, reduced, 1.0),
    }  # fmt: skip
    taken = inspect.signature(law).parameters

    def size(gap):
        if surface == "bubble":
            return math.sqrt(2 * reduced * gap + abs(push) * reduced / (math.pi * 0.3))
        kappa = SoftPair(2 * reduced, 1.0, 0.1)
        return contact_size(reduced, gap, deflection_under_force(kappa, gap, push), 1.0, 1.0)

    def rate(_, q):
        gap = math.exp(q[0])
        film = law(*((known | {"contact_size": size(gap), "gap": gap})[name] for name in taken))
        return [push / film.squeeze / gap]

    end = solve_ivp(rate, (0, 30.0), [math.log(0.02)], method="Radau", rtol=1e-9, atol=1e-10).y[0, -1]
    assert state.log_gap[0] == pytest.approx(end, abs=1e-6)
    assert abs(end - math.log(0.02)) > 0.02


@pytest.mark.parametrize(("radii", "moduli"), [((1.0, 0.3), (1.0, 1.0)), ((1.0, 2.5), (0.4, 5.0))])
@pytest.mark.parametrize("prefactors", ["paper", "physical"])
def test_unlike_spheres_move_as_alike_ones_of_the_same_reduced_radius_and_modulus(radii, moduli, prefactors):
    alike = SoftPair(2 * reduced_radius(*radii), pair_modulus(*moduli), 0.1)
    alike = dataclasses.replace(alike, prefactors=_set(prefactors))
    time = passage_time(alike, 1e-3, 0.02, 0.1)
    scene = pair((1e-3, 0.0), radii=radii, moduli=moduli, duration=time, films={"prefactors": prefactors})
    swapped = pair((1e-3, 0.0), radii=radii[::-1], moduli=moduli[::-1], duration=time, films={"prefactors": prefactors})
    ends = [integrated(one)[1] for one in (scene, swapped)]
    assert math.exp(ends[0].log_gap[0]) == pytest.approx(0.1, rel=1e-6)
    assert ends[1].log_gap[0] == pytest.approx(ends[0].log_gap[0], abs=1e-12)


def _set(name):
    from ecume.laws.soft_pair import PREFACTORS

    return PREFACTORS[name]


@pytest.mark.parametrize("surface", SURFACES)
def test_sheared_unlike_spheres_do_not_care_who_is_first(surface):
    given = {"duration": 5.0, "films": {"surface": surface, "interface": "drop"}, "liquid": {
        "viscosity": 0.1, "surface_tension": 0.3}, "hydrodynamics": {"drag": "stokes"}, "rotation": True}  # fmt: skip
    one = integrated(pair((-1e-3, 2e-3), radii=(1.0, 0.6), moduli=(0.5, 3.0), **given))[1]
    other = integrated(pair((-1e-3, 2e-3), radii=(0.6, 1.0), moduli=(3.0, 0.5), **given))[1]
    # Half a turn about the middle puts the first in the place of the second.
    assert 1.62 - other.position[::-1, 0] == pytest.approx(one.position[:, 0], abs=1e-10)
    assert -other.position[::-1, 1] == pytest.approx(one.position[:, 1], abs=1e-10)
    assert other.orientation == pytest.approx(one.orientation[::-1], abs=1e-10)
    assert np.abs(one.orientation).min() > 1e-4


STERIC = {"law": "steric", "steric_strength": 0.02, "steric_length": 0.04}


def pressed(pull, coefficient=0.5, friction="coulomb", duration=20.0):
    """Two spheres pressed together with 0.01 onto steric layers, inside their roughness, and sheared."""
    films = {
        "friction": friction, "friction_coefficient": coefficient, "roughness": 0.1, "tangential_law": "secant",
        "critical_load": 0.0,
    }  # fmt: skip
    ramp = [{"time": 0.0, "load": 1.0}]
    return pair((-0.01, pull), gap=0.02, duration=duration, films=films, long_range_forces=STERIC, protocol=ramp)


def test_pressed_spheres_stick_below_the_cone_of_friction_and_slide_above():
    stuck, slides, free = (
        integrated(pressed(pull, friction=friction))[1]
        for pull, friction in ((0.0045, "coulomb"), (0.0055, "coulomb"), (0.0045, "none"))
    )
    # The gap vector tells how far the surfaces have slid; the centers go on to yield a little.
    assert abs(stuck.direction[0, 1]) < 1e-14
    assert slides.direction[0, 1] > 1e-3
    assert free.direction[0, 1] > 2 * slides.direction[0, 1]


@pytest.mark.parametrize(("critical", "stuck"), [(0.002, True), (0.004, False), (0.02, False)])
def test_friction_holds_the_load_above_the_critical_one_and_no_more(critical, stuck):
    """Of a load of 0.01, with a coefficient of 0.7, tips hold 0.0056, 0.0042 and nothing against a pull of 0.0049."""
    scene = to_plain(pressed(0.0049, coefficient=0.7, friction="critical-load"))
    scene["films"] |= {"critical_load": critical}
    state = integrated(from_plain(scene))[1]
    assert (abs(state.direction[0, 1]) < 1e-14) == stuck


def test_what_slides_is_slowed_by_the_film_under_the_rest_of_the_pull():
    scene = pressed(0.008, coefficient=0.3, duration=0.5)
    parameters, state = integrated(scene)
    work = SOFT.workspace(parameters, state, 1.0)
    shown = SOFT.observe(parameters, state, work)
    tension, shear, gap = (shown.arrays[name][0, 0] for name in ("tension", "shear", "gap"))
    size = contact_size(0.5, gap, 0.01, 1.0, 1.0)
    # The contact size of the law, by the deflection that bears the tension.
    for _ in range(50):
        size = contact_size(0.5, gap, tension / size, 1.0, 1.0)
    friction = INTERFACES["rigid"](size, gap, 0.1, 1.0, (1.5 * math.pi, math.pi)).shear
    speed = (shear - 1.01 * 0.3 * -tension) / friction
    assert np.linalg.norm(work.step.responses.slope[0, 1:]) * (2.0 + gap) == pytest.approx(speed, rel=1e-9)


def sheared(**films):
    """A dense layer of rough spheres."""
    plain = {
        "model": "soft", "duration": 5.0, "frame_every": 1.0, "liquid": {"viscosity": 1e-3, "surface_tension": 0.5},
        "particles": [{"radius": r, "modulus": 1.0, "count": 12} for r in (1.0, 1.3)],
        "cell": {"size": [12.4, 12.4], "minimum_gap": 0.01}, "rotation": True, "films": films,
        "protocol": [{"time": 0.0}, {"time": 5.0, "strain": 0.2}],
        "integration": {"integrator": "tr-bdf2", "tolerance": 1e-3},
    }  # fmt: skip
    return from_plain(plain)


def test_rough_layers_are_harder_to_shear_and_their_steps_are_solved():
    stresses = []
    for films in ({}, {"friction": "coulomb", "friction_coefficient": 1.0, "roughness": 0.02}):
        frames = list(simulate(sheared(**films)))
        stresses.append(np.mean([frame.numbers["shear_stress"] for frame in frames[2:]]))
        assert frames[-1].numbers["rejected_steps"] < 0.3 * frames[-1].numbers["time_steps"]
    assert stresses[1] > 1.1 * stresses[0]


MOBILE = {"interface": "mobile", "tension_law": "symmetric"}
"""Below jamming, spheres without sliding friction are held by tension alone."""


@pytest.mark.long
@pytest.mark.parametrize("films", [{"surface": "bubble"}, {"interface": "drop"}, MOBILE])
def test_layers_of_bubbles_and_drops_flow_and_stay_dissipative(films):
    parameters, state = integrated(sheared(**films))
    # Where nothing resists sliding, packings buckle, and steps are cut short for it.
    assert state.tally[FAILED] < 0.2 * state.tally[ACCEPTED]
    frame = SOFT.observe(parameters, state, SOFT.workspace(parameters, state, 1.0))
    assert frame.numbers["shear_stress"] > 0.0
    assert frame.numbers["elastic_energy"] > 0.0


BARE = [{"radius": 1.0, "positions": [[x, 0.0]]} for x in (0.0, 2.1)]


@pytest.mark.parametrize(
    ("more", "path", "says"),
    [
        ({"films": {"surface": "jelly"}}, "films.surface", "hertz, bubble"),
        ({"films": {"interface": "oily"}}, "films.interface", "rigid, half-mobile, mobile, drop"),
        ({"films": {"friction": "glue", "roughness": 0.1}}, "films.friction", "none, coulomb, critical-load"),
        ({"films": {"friction": "coulomb"}}, "films.roughness", "got none"),
        ({"films": {"friction": "critical-load", "roughness": 0.1}}, "films.critical_load", "got none"),
        ({"particles": BARE}, "particles[0].modulus", "got none"),
        ({"films": {"surface": "bubble"}, "liquid": {"viscosity": 1.0}}, "liquid.surface_tension", "got none"),
    ],
)
def test_what_a_law_lacks_is_said(more, path, says):
    with pytest.raises(SceneError) as caught:
        SOFT.parameters(pair(**more))
    assert caught.value.faults[0].path == path
    assert says in caught.value.faults[0].message


def test_bubbles_need_no_modulus():
    scene = pair(films={"surface": "bubble"}, particles=BARE)
    assert SOFT.parameters(scene).modulus == pytest.approx([0.3, 0.3])
    assert "reduced force" in [row[0] for row in SOFT.summary(pair(films={"surface": "bubble"}))]
    assert FilmSpec().surface == "hertz"
