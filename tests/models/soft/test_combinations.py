"""All kinds of loading of a packing with all kinds of resistance: each runs, or is refused with a physical reason."""

import itertools

import numpy as np
import pytest

from ecume.analysis.rheology import stress_tensor
from ecume.errors import SceneError
from ecume.models.soft import SOFT
from ecume.models.soft.report.balance_report import windings
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

pytestmark = [pytest.mark.compiled]

SHEARS = {
    "strain": [{"time": 0.0}, {"time": 0.2, "strain": 0.01}],
    "shear rate": [{"time": 0.0, "shear_rate": 0.05}],
    "shear stress": [{"time": 0.0, "shear_stress": 1e-4}],
}
SIZES = {
    "fixed": {},
    "height rate": {"height_rate": -0.01},
    "normal stress": {"normal_stress": 1e-3},
    "pressure": {"pressure": 1e-3},
}
FORCES = {"none": {}, "steric": {"law": "steric", "steric_strength": 1e-3, "steric_length": 0.03}}
CHOICES = list(itertools.product(SHEARS, SIZES, ("none", "stokes"), (False, True), ("none", "coulomb"), FORCES, (2, 3)))


def boxed(shear, size, drag, rotation, friction, force, dimensions=2, filled=0.8, **more):
    first, *rest = SHEARS[shear]
    films = {"friction": friction, "roughness": 0.05} if friction != "none" else {}
    given = {
        "model": "soft", "duration": 0.2, "frame_every": 0.1, "seed": 3, "rotation": rotation,
        "liquid": {"viscosity": 1e-3}, "hydrodynamics": {"drag": drag}, "films": films,
        "particles": [{"radius": radius, "modulus": 1.0, "count": 8} for radius in (1.0, 1.3)],
        "cell": {"size": [1.0] * dimensions, "volume_fraction": filled if dimensions == 2 else 0.7 * filled},
        "long_range_forces": FORCES[force],
        "protocol": [first | SIZES[size], *rest],
        "integration": {"integrator": "tr-bdf2", "tolerance": 1e-3},
    }  # fmt: skip
    return from_plain(given | more)


def holds(frames, scene):
    """The conditions that every run satisfies: balance of forces, imposed stresses, and energy budget."""
    stage, first = scene.protocol[0], frames[0].numbers
    for frame in frames:
        numbers = frame.numbers
        assert numbers["imbalance"] < 1e-7
        for name in ("shear_stress", "normal_stress", "pressure"):
            if (wanted := getattr(stage, name)) is not None:
                assert numbers[name] == pytest.approx(wanted, rel=1e-7)
        if scene.rotation and scene.hydrodynamics.drag == "none":
            tensor = stress_tensor(frame)
            assert tensor == pytest.approx(tensor.T, abs=1e-7 * np.abs(tensor).max() + 1e-15)
    last = frames[-1].numbers
    spent = last["dissipated_work"] + last["size_work"] + last["total_energy"] - first["total_energy"]
    scale = last["dissipated_work"] + abs(last["total_energy"]) + abs(last["contact_work"])
    assert abs(last["injected_work"] - spent) < 1e-2 * scale


@pytest.mark.parametrize("number", np.random.default_rng(1).permutation(len(CHOICES))[:16])
def test_whatever_is_imposed_runs_with_whatever_resists(number):
    shear, size, drag, rotation, friction, force, dimensions = CHOICES[number]
    scene = boxed(shear, size, drag, rotation, friction, force, dimensions)
    holds(list(simulate(scene)), scene)


@pytest.mark.parametrize("size", ["normal stress", "pressure"])
def test_spins_are_turned_by_the_liquid_of_a_cell_that_answers_to_a_shear_stress(size):
    scene = boxed("shear stress", size, "stokes", True, "none", "steric")
    frames = list(simulate(scene))
    holds(frames, scene)
    assert frames[0].numbers["imbalance"] == 0.0


@pytest.mark.parametrize(("filled", "rotation", "says"), [
    (0.3, False, "no films lead around the cell"), (0.55, True, "the films bear no stress, however small"),
])  # fmt: skip
def test_a_start_too_loose_for_a_stress_is_refused_with_what_helps(filled, rotation, says):
    null_space_dimension = boxed("shear rate", "normal stress", "none", rotation, "none", "none", filled=filled)
    with pytest.raises(SceneError, match=f"{says}.*hydrodynamics.drag = 'stokes', a larger films.cutoff"):
        SOFT.start(null_space_dimension, SOFT.parameters(null_space_dimension))
    carried = boxed("shear rate", "normal stress", "stokes", rotation, "none", "none", filled=filled)
    holds(list(simulate(carried)), carried)


def test_films_wind_around_a_cell_where_a_row_of_spheres_does():
    row = [{"radius": 1.0, "modulus": 1.0, "positions": [[1.02 + 2.05 * k, 1.0] for k in range(6)]}]
    for cell, wanted in (([12.3, 14.0], [[-1, 0], [1, 0]]), ([20.0, 14.0], [])):
        scene = from_plain(
            {"model": "soft", "duration": 1.0, "frame_every": 1.0, "liquid": {"viscosity": 1.0}, "particles": row}
            | {"cell": {"size": cell}}
        )
        assert windings(SOFT.start(scene, SOFT.parameters(scene))).tolist() == wanted


def test_a_wall_that_no_film_holds_against_its_pressure_is_refused():
    scene = from_plain(
        {
            "model": "soft", "duration": 1.0, "frame_every": 1.0, "liquid": {"viscosity": 1.0},
            "particles": [{"radius": 1.0, "modulus": 1.0, "positions": [[1.0, 1.1], [3.1, 1.1]]}],
            "cell": {"size": [4.2, 9.0]}, "walls": [{"side": "bottom"}, {"side": "top", "pressure": 1e-3}],
        }
    )  # fmt: skip
    with pytest.raises(SceneError, match="no film holds the top wall against its stress"):
        SOFT.start(scene, SOFT.parameters(scene))


JUMP = [{"time": 0.0}, {"time": 0.2}, {"time": 0.2, "strain": 0.01}]
WAVE = [{"time": 0.0, "oscillation": {"frequency": 10.0, "amplitude": 1e-3}}]


@pytest.mark.long
@pytest.mark.parametrize(("protocol", "drag"), [(JUMP, "none"), (WAVE, "stokes")])
@pytest.mark.parametrize("integrator", ["esdirk4", "tr-bdf2"])
def test_work_is_as_accurate_as_the_tolerance_after_a_jump_and_in_an_oscillation(protocol, drag, integrator):
    missing = []
    for tolerance in (1e-3, 1e-5):
        scene = boxed(
            "strain", "fixed", drag, False, "none", "none", duration=0.4, frame_every=0.1, protocol=protocol,
            integration={"integrator": integrator, "tolerance": tolerance},
        )  # fmt: skip
        first, *_, last = (frame.numbers for frame in simulate(scene))
        spent = last["dissipated_work"] + last["size_work"] + last["total_energy"] - first["total_energy"]
        missing.append(abs(last["injected_work"] - spent) / last["dissipated_work"])
    assert missing[0] < 5e-3
    assert missing[1] < 0.3 * missing[0]
