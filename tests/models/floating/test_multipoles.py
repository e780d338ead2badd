"""Floats beyond superposition, in motion."""

import dataclasses

import numpy as np
import pytest
from scipy.special import k0

from ecume.errors import SceneError
from ecume.laws import multipole
from ecume.models.floating import FLOATING
from ecume.models.floating.forces.multipoles import heights_at, multipoles_in, solved
from ecume.models.floating.setup.kinds import float_kinds
from ecume.models.liquids import liquid_of
from ecume.scenes.floating import (
    DiscSpec,
    DishSpec,
    FloatingScene,
    FloatSpec,
    HydrodynamicsSpec,
    IntegrationSpec,
    InteractionSpec,
)
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from tests.models import begun

SMALL = 0.27e-3
"""A tenth of the capillary length of water."""


def discs(positions, method, radius=1.35e-3, dish=None, drag=True, **options):
    body = FloatSpec(
        radius=radius, density=300.0, disc=DiscSpec(thickness=0.4 * radius), positions=tuple(map(tuple, positions))
    )
    return FloatingScene(
        duration=options.pop("duration", 0.02),
        frame_every=options.pop("frame_every", 0.01),
        particles=(body,),
        dish=dish,
        hydrodynamics=HydrodynamicsSpec(drag="stokes" if drag else "none"),
        integration=IntegrationSpec(time_step=options.pop("time_step", None)),
        interaction=InteractionSpec(method=method, charge="linear", **options),
    )


def forces(scene):
    """The forces at the start, as in the time integration."""
    parameters, state, workspace = begun(scene)
    FLOATING.advance(parameters, state, workspace, 0)
    return workspace.force.copy()


def hexagon(radius, gap):
    places = [(0.0, 0.0), *((np.cos(k * np.pi / 3), np.sin(k * np.pi / 3)) for k in range(6))]
    return 2.0 * radius * (1.0 + gap) * np.array(places)


@pytest.mark.long
@pytest.mark.parametrize(
    "dish",
    [
        None,
        DishSpec(radius=8e-3, contact_angle=0.9),
        pytest.param(DishSpec(size=(0.02, 0.015), contact_angle=0.9), marks=pytest.mark.compiled),
    ],
)
def test_the_integration_has_the_forces_of_the_solver(dish):
    places = np.array([[1e-3, 0.5e-3], [4e-3, 1e-3], [-2e-3, -2e-3]])
    scene = discs(places, "multipole", dish=dish, order=6, accuracy=1e-9)
    walls = None
    if dish is not None:
        walls = multipole.Dish(8e-3, 0.9) if dish.radius else multipole.Basin(0.02, 0.015, 0.9)
    (kind,) = float_kinds(scene)
    found = multipole.solve(places, [kind.body] * 3, liquid_of(scene), 6, walls=walls)
    assert forces(scene) == pytest.approx(found.forces, rel=1e-6, abs=1e-6 * np.abs(found.forces).max())


@pytest.mark.long
@pytest.mark.compiled
def test_two_discs_feel_the_same_by_corrected_pairs_as_by_multipoles():
    for apart in (2.0001, 2.03, 2.4, 5.0):
        places = [[0.0, 0.0], [apart * SMALL, 0.0]]
        exact = forces(discs(places, "multipole", SMALL, order=24))[0, 0]
        assert forces(discs(places, "pair-corrected", SMALL))[0, 0] == pytest.approx(exact, rel=2e-4)
        assert forces(discs(places, "superposition", SMALL))[0, 0] < 0.95 * exact


@pytest.mark.long
@pytest.mark.compiled
def test_a_raft_of_seven_small_discs_is_held_six_times_as_hard_as_superposition_says():
    places = hexagon(SMALL, 0.02)
    pull = {
        method: -forces(discs(places, method, SMALL, order=16))[1, 0]
        for method in ("superposition", "pair-corrected", "multipole")
    }
    assert pull["multipole"] / pull["superposition"] == pytest.approx(5.74, abs=0.1)
    assert pull["superposition"] < pull["pair-corrected"] < pull["multipole"]


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("method", ["multipole", "pair-corrected"])
def test_energy_and_momentum_last_where_nothing_drags(method):
    places = np.array([[0.0, 0.0], [4.0e-3, 0.0], [1.5e-3, 3.5e-3]])
    scene = discs(places, method, drag=False, order=6, duration=0.06, frame_every=0.02)
    frames = list(simulate(scene))
    kinetic = frames[-1].numbers["kinetic_energy"]
    lost = frames[-1].numbers["total_energy"] - frames[0].numbers["total_energy"]
    assert kinetic > 0.0
    assert abs(lost) < 2e-3 * kinetic
    mass = frames[0].arrays["mass"].sum()
    assert abs(frames[-1].numbers["momentum_x"]) < 1e-12 * np.sqrt(2.0 * kinetic * mass)


def ends(places, **options):
    """The final distance of the first two floats, by each method."""
    found = {}
    for method in ("superposition", "pair-corrected", "multipole"):
        *_, last = simulate(discs(places, method, drag=False, time_step=2e-4, **options))
        found[method] = float(np.hypot(*np.diff(last.arrays["position"][:2], axis=0)[0]))
    return found


@pytest.mark.long
@pytest.mark.compiled
def test_two_discs_move_by_corrected_pairs_as_by_multipoles_and_three_nearly_so():
    """From 1.1 diameters: corrections hold for a pair to the error of their table, and for three recover a part."""
    places = 2.97e-3 * np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 3.0**0.5 / 2]])
    two, three = (ends(some, order=8, duration=0.04, frame_every=0.02) for some in (places[:2], places))
    went = 2.97e-3 - two["multipole"]
    assert two["pair-corrected"] == pytest.approx(two["multipole"], abs=2e-3 * went)
    assert abs(two["superposition"] - two["multipole"]) > 0.03 * went
    missing = {method: abs(end - three["multipole"]) for method, end in three.items()}
    assert missing["pair-corrected"] < 0.7 * missing["superposition"]


def test_what_does_not_go_together_is_refused():
    scene = discs([[0.0, 0.0]], "multipoles")
    with pytest.raises(SceneError, match="did you mean 'multipole'"):
        FLOATING.parameters(scene)
    legacy = discs([[0.0, 0.0]], "multipole", dish=DishSpec(radius=0.02, law="two-point-legacy"))
    with pytest.raises(SceneError, match="whose meniscus is that of the surface"):
        FLOATING.parameters(legacy)
    text = (
        'model = "floating"\nduration = "1 s"\nframe_every = "1 s"\n[[particles]]\nradius = "1 mm"\ndensity = 300.0\n'
    )
    both = text + 'contact_angle = "70 deg"\ndisc = { thickness = "1 mm" }\n'
    with pytest.raises(SceneError, match="a disc pins the contact line"):
        load_scene(both)
    assert load_scene(text + 'disc = { thickness = "1 mm" }\n').particles[0].disc.rim == "bottom"


def test_a_disc_says_how_it_floats():
    scene = dataclasses.replace(discs([[0.0, 0.0]], "superposition"), title="one")
    report = {name: remark for name, _, remark in FLOATING.summary(scene)}
    assert report["float-1: capillary charge"] == "heavy: attracts heavy floats"
    assert "leans" in report["float-1: stability"]


def test_a_disc_alone_bends_the_surface_alike_in_all_directions():
    scene = discs([[1e-3, 2e-3]], "multipole")
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    (frame,) = [FLOATING.observe(parameters, state, FLOATING.workspace(parameters, state, 1.0))]
    multipoles = multipoles_in(parameters)
    scratch, angles, length = solved(parameters, frame), np.linspace(0.0, 6.0, 7), multipoles.length
    around = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    near, far = (
        heights_at(multipoles, scratch, state.position[0] + distance * around) for distance in (0.5 * length, length)
    )
    assert near == pytest.approx(near[0] * np.ones(7), rel=1e-9, abs=0.0)
    assert near / far == pytest.approx(np.full(7, k0(0.5) / k0(1.0)), rel=1e-9)
