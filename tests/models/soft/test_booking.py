"""The energy budget of soft spheres: exact for constant forces, and otherwise closing better with finer steps."""

import dataclasses
import functools
import math

import numpy as np
import pytest

from ecume.laws.soft_pair import PREFACTORS, SoftPair, surface_energy
from ecume.models.invariants import ENERGY, NumberHistory
from ecume.models.soft import SOFT
from ecume.models.soft.integration.dirk_schemes import LOOSE, ROUNDED, error_of_run
from ecume.models.soft.integration.linear_solvers import begin_step
from ecume.models.soft.protocol import drive_at
from ecume.models.soft.report.energy_budget import DRAG, FILMS, INJECTED, SIZE, elastic_energy, energy_of_faded
from ecume.scenes.schema import from_plain
from ecume.scenes.soft import StageSpec
from ecume.simulation import simulate
from tests.oracles.soft_contacts import deflection_under_force

from .clusters import integrated, pull_apart
from .test_packings import packing
from .test_walls import channel

PAIR, FORCE = SoftPair(1.0, 1.0, 1.0), 1e-3
SPUN = {"drag": "stokes"}


def stepped(scene, tolerance, scheme="tr-bdf2"):
    return dataclasses.replace(
        scene, integration=dataclasses.replace(scene.integration, tolerance=tolerance, integrator=scheme)
    )


def ends(scene):
    """The first and the last frame's numbers, and their differences."""
    frames = list(simulate(scene))
    first, last = frames[0].numbers, frames[-1].numbers
    return first, last, {name: last[name] - first[name] for name in last}


def missing(change):
    """The residual of the energy budget."""
    return change["injected_work"] - sum(change[key] for key in ("total_energy", "dissipated_work", "size_work"))


def test_the_energy_budget_of_a_pair_under_a_constant_force_is_exact():
    """The film takes F times what the gap opens by; what deflections take beside what they hold is the size's."""
    scene = pull_apart(0.01, FORCE, tolerance=1e-8, duration=1e4)
    first, last, change = ends(scene)
    gaps = first["smallest_gap"], last["smallest_gap"]
    stretch = [deflection_under_force(PAIR, gap, FORCE) for gap in gaps]
    held = [
        surface_energy(one, gap=gap, reduced_radius=0.5, modulus=1.0, prefactors=PREFACTORS["paper"])
        for one, gap in zip(stretch, gaps, strict=True)
    ]
    opened, stretched = gaps[1] - gaps[0], stretch[1] - stretch[0]
    assert opened > 0.015
    assert change["injected_work"] == pytest.approx(FORCE * (opened + stretched), rel=1e-7, abs=0.0)
    assert change["dissipated_work"] == pytest.approx(FORCE * opened, rel=1e-6, abs=0.0)
    assert change["total_energy"] == pytest.approx(held[1] - held[0], rel=1e-6, abs=0.0)
    assert change["size_work"] == pytest.approx(FORCE * stretched - (held[1] - held[0]), rel=1e-5, abs=0.0)
    assert change["size_work"] < 0.0  # a gap that opens stiffens its contact


@pytest.mark.long
@pytest.mark.parametrize(("scheme", "order"), [("tr-bdf2", 2), ("esdirk4", 4)])
def test_the_error_of_the_energy_budget_falls_with_the_order_of_the_scheme(scheme, order):
    left, steps = [], []
    for tolerance in (1e-4, 1e-6):
        _, last, change = ends(stepped(pull_apart(0.01, FORCE, duration=2e4), tolerance, scheme))
        left.append(abs(missing(change)))
        steps.append(last["time_steps"])
    assert math.log(left[0] / left[1]) > 0.95 * order * math.log(steps[1] / steps[0])


def ramped():
    """Two spheres separated by a load that increases."""
    scene = pull_apart(0.01, 0.01, duration=50.0)
    return dataclasses.replace(scene, protocol=(StageSpec(time=0.0, load=0.0), StageSpec(time=50.0, load=1.0)))


def sinking():
    """Two spheres that sink onto a wall, one of which an increasing torque rolls along it."""
    one, other = (
        {"radius": 1.0, "modulus": 1.0, "density": 2.0, "positions": [[x, 1.02]], "torque": [torque]}
        for x, torque in ((0.0, -0.01), (2.1, 0.0))
    )
    return from_plain({
        "model": "soft", "duration": 2.0, "frame_every": 2.0, "gravity": [0.0, -1e-3], "rotation": True,
        "liquid": {"viscosity": 1e-3, "density": 1.0}, "hydrodynamics": {"drag": "stokes"}, "particles": [one, other],
        "walls": [{"side": "bottom", "position": 0.0}],
        "protocol": [{"time": 0.0, "load": 0.0}, {"time": 2.0, "load": 1.0}],
    })  # fmt: skip


RUN = {"count": 3, "duration": 2.0}
DRIVEN = {
    "a load": ramped,
    "weights and torques": sinking,
    "shear and size": lambda: packing(**RUN, protocol=[{"time": 0.0}, {"time": 2.0, "strain": 0.1, "scale": 0.99}]),
    "drag": lambda: packing(**RUN, strain=0.1, hydrodynamics=SPUN),
    "spins": lambda: packing(3, **RUN, filled=0.45, strain=0.1, rotation=True, hydrodynamics=SPUN),
    "friction": lambda: packing(
        **RUN, strain=0.1, films={"friction": "coulomb", "friction_coefficient": 0.5, "roughness": 0.03}
    ),
    "unlike stiffnesses": lambda: packing(**RUN, strain=0.1, films={"tangential": 0.4}),
    "long-range": lambda: packing(
        **RUN, strain=0.1, long_range_forces={"law": "steric", "steric_strength": 2e-3, "steric_length": 0.05}),
    "bubbles": lambda: packing(
        **RUN, strain=0.1, films={"surface": "bubble"}, liquid={"viscosity": 1e-3, "surface_tension": 0.5}
    ),
    "stresses": lambda: packing(**RUN, protocol=[{"time": 0.0, "pressure": 1e-3, "shear_stress": 2e-4}]),
    "a wall that goes": lambda: channel({"top": {"velocity": [0.05, -0.02], "modulus": 2.0}}, count=5, rotation=True),
    "a wall that yields": lambda: channel({"top": {"velocity": [0.05, 0.0], "pressure": 1e-3}}, count=5),
}  # fmt: skip


@pytest.mark.sampled(3)
@pytest.mark.compiled
@pytest.mark.parametrize(
    "driven", [pytest.param(name, marks=[pytest.mark.long] * ("wall" in name or "torques" in name)) for name in DRIVEN]
)
def test_what_is_put_in_is_held_dissipated_or_the_sizes(driven):
    """Whoever drives, to a ten-thousandth of what moved; each part of the budget is more."""
    scheme = "esdirk4" if driven in ("a load", "weights and torques") else "tr-bdf2"
    _, _, change = ends(stepped(DRIVEN[driven](), 1e-6, scheme))
    moved = change["dissipated_work"] + abs(change["total_energy"])
    assert abs(missing(change)) < 1e-4 * moved
    assert abs(change["size_work"]) > 2e-4 * moved


def test_a_jump_does_the_work_that_deflections_take_up():
    spheres = pull_apart(0.01, FORCE, tolerance=1e-4, duration=20.0, frames=2)
    loads = ((0.0, 1.0), (10.0, 1.0), (10.0, 2.0))
    jumping = dataclasses.replace(spheres, protocol=tuple(StageSpec(time=time, load=load) for time, load in loads))
    calm, last = (list(simulate(scene))[1].numbers for scene in (spheres, jumping))
    taken_up = last["total_energy"] - calm["total_energy"]
    assert taken_up > 2.0 * calm["total_energy"]
    assert last["injected_work"] - calm["injected_work"] == pytest.approx(taken_up, rel=1e-6, abs=0.0)


@pytest.mark.long
@pytest.mark.parametrize("every", [0.1, 0.3, 0.7])
def test_a_jump_at_any_frame_is_made_however_the_time_of_the_frame_is_rounded(every):
    """Three times 0.1 is no 0.3 in binary."""
    for frame in (1, 2, 3, 6, 7):
        time = float(f"{frame * every:.1f}")
        pulled = pull_apart(0.01, FORCE, tolerance=1e-3, duration=8 * every, frames=8)
        loads = ((0.0, 1.0), (time, 1.0), (time, 2.0))
        stages = tuple(StageSpec(time=at, load=load) for at, load in loads)
        frames = list(simulate(dataclasses.replace(pulled, frame_every=every, protocol=stages)))
        assert len(frames) == 9
        energies = [one.numbers["total_energy"] for one in frames]
        assert energies[frame] > 2.0 * energies[frame - 1]


@pytest.mark.parametrize("span", [0.05, 5.0, 50.0])
@pytest.mark.parametrize("scheme", ["esdirk4", "tr-bdf2"])
def test_the_work_of_a_fast_ramp_is_as_accurate_as_the_tolerance(scheme, span):
    """A ramp that one step takes is held to the budget as a jump is."""
    pressed = pull_apart(0.01, -20.0 * FORCE, tolerance=1e-3, duration=5e4, frames=10)
    loads = ((0.0, 0.0), (1.5e4, 0.0), (1.5e4 + span, 1.0))
    ramp = dataclasses.replace(pressed, protocol=tuple(StageSpec(time=time, load=load) for time, load in loads))
    _, _, change = ends(stepped(ramp, 1e-3, scheme))
    assert abs(missing(change)) < error_of_run(scheme, 1e-3) / LOOSE * change["injected_work"]


@pytest.mark.long
@pytest.mark.compiled
def test_films_take_what_contacts_hold_that_fade():
    scene = channel({}, count=5)
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    step = SOFT.workspace(parameters, state, 1.0).step
    begin_step(parameters, step, drive_at(parameters.protocol, 0.0))
    assert len(step.log_gap) > 0 < len(step.walls.touches.first)
    assert energy_of_faded(parameters.contacts, step) == 0.0
    gone = math.log(1.1 * parameters.contacts.fade_to)
    for log_gap in (step.log_gap, step.films.log_gap, step.walls.touches.log_gap):
        log_gap[:] = gone
    held = elastic_energy(parameters.contacts, step)
    assert held > 0.0
    assert energy_of_faded(parameters.contacts, step) == pytest.approx(held, rel=1e-12, abs=0.0)


STRESSED = [{"time": 0.0, "pressure": 1e-3}, {"time": 1.0}, {"time": 1.0, "pressure": 1e-3, "shear_stress": 1e-4}]
COURSES = {
    "a shear": {"strain": 0.05},
    "a jump": {"protocol": [{"time": 0.0}, {"time": 1.0}, {"time": 1.0, "strain": 0.01}]},
    "a creep": {"protocol": STRESSED, "hydrodynamics": {"drag": "stokes"}},
    "an oscillation": {"protocol": [{"time": 0.0, "oscillation": {"frequency": 1.0, "amplitude": 1e-3}}]},
}


@functools.cache
def numbers_of_a_course(course, scheme, tolerance):
    found = list(simulate(stepped(packing(**RUN, **COURSES[course], frame_every=0.5), tolerance, scheme)))
    names = ("shear_stress", "pressure", "injected_work", "dissipated_work", "total_energy")
    return {name: np.array([frame.numbers[name] for frame in found]) for name in names}


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("scheme", ["tr-bdf2", "esdirk4"])
@pytest.mark.parametrize("course", COURSES)
def test_stresses_and_work_are_as_accurate_as_the_tolerance_says(course, scheme):
    """Against a run of the finest tolerance, in all frames, relative to the largest stress and to the work put in."""
    exact = numbers_of_a_course(course, "esdirk4", 1e-9)
    for tolerance in (1e-3, 1e-5):
        for name, values in numbers_of_a_course(course, scheme, tolerance).items():
            scale = np.abs(exact["injected_work" if name == "total_energy" else name]).max()
            assert np.abs(values - exact[name]).max() < error_of_run(scheme, tolerance) * scale, name


@pytest.mark.parametrize(("scheme", "times"), [("tr-bdf2", 4.0), ("esdirk4", 8.0**0.8)])
def test_the_defect_that_is_allowed_follows_the_order_of_the_scheme(scheme, times):
    """Eight times the tolerance e: e^(2/3) in second order, e^(4/5) in fourth."""
    one, other = (error_of_run(scheme, tolerance) for tolerance in (1e-3, 8e-3))
    assert other - ROUNDED == pytest.approx(times * (one - ROUNDED), rel=1e-9)


@pytest.mark.compiled
def test_the_energy_budget_of_an_interrupted_run_has_the_same_bits():
    scene = stepped(packing(count=3, duration=2.0, strain=0.1, hydrodynamics=SPUN), 1e-3)
    budget = [integrated(scene, parts=parts)[1].budget for parts in (1, 10**6)]
    assert budget[0].tobytes() == budget[1].tobytes()
    assert np.all(budget[0][[INJECTED, FILMS, DRAG]] > 0.0)
    assert budget[0][SIZE] != 0.0


def test_a_run_of_an_earlier_version_continues_without_an_energy_budget():
    scene = pull_apart(0.01, FORCE, tolerance=1e-3, duration=1.0)
    parameters = SOFT.parameters(scene)
    state = SOFT.start(scene, parameters)
    former = type(state)(**{key: value for key, value in state._asdict().items() if key != "budget"})
    scratch = SOFT.workspace(parameters, former, 1.0)
    SOFT.advance(parameters, former, scratch, parameters.steps_per_frame)
    numbers = SOFT.observe(parameters, former, scratch).numbers
    assert "injected_work" not in numbers
    (energy,) = (one for one in SOFT.invariants(scene, parameters) if one.name == ENERGY)
    assert energy.value(NumberHistory(numbers, numbers, numbers, numbers)) == 0.0
