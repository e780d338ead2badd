"""The report of `ecume check` on soft spheres: forces by their cause, warnings, and costs."""

import math

import pytest

from ecume.laws.soft_pair import SoftPair, passage_time
from ecume.models.soft import SOFT
from ecume.models.soft.report.check_report import (
    doubts,
    forces,
    largest_deflection,
    pressed_force,
    sheared_force,
    steps_of,
    strain_of,
    typical_pair,
)
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate
from ecume_validation import rheology

pytestmark = pytest.mark.compiled


def packing(radii=(1.0, 1.4), count=18, filled=0.7, **more):
    plain = {
        "model": "soft", "duration": 4.0, "frame_every": 4.0, "liquid": {"viscosity": 1e-3},
        "particles": [{"radius": radius, "modulus": 1.0, "count": count} for radius in radii],
        "cell": {"size": [1.0, 1.0], "volume_fraction": filled, "minimum_gap": 0.02},
        "integration": {"integrator": "tr-bdf2", "tolerance": 1e-3},
    }  # fmt: skip
    return from_plain(plain | more)


def two(force, **more):
    spheres = [
        {"radius": 1.0, "modulus": 1.0, "positions": [[x, 0.0]], "force": [f, 0.0]}
        for x, f in ((0.0, -force), (2.01, force))
    ]
    plain = {"model": "soft", "duration": 1.0, "frame_every": 1.0, "liquid": {"viscosity": 1.0}, "particles": spheres}
    return from_plain(plain | more)


def begun(scene):
    parameters = SOFT.parameters(scene)
    return parameters, SOFT.start(scene, parameters)


def expected(scene):
    return typical_pair(scene, *begun(scene))


def report(scene):
    parameters, state = begun(scene)
    return " ".join(row[2] for row in doubts(scene, parameters, typical_pair(scene, parameters, state)))


@pytest.mark.parametrize(("walls", "reported"), [([], True), ([{"side": "bottom"}], False)])
def test_spheres_without_films_are_reported_unless_they_can_meet_a_wall(walls, reported):
    spheres = [{"radius": 1.0, "modulus": 1.0, "positions": [[x, 20.0]]} for x in (10.0, 30.0)]
    apart = packing(particles=spheres, cell={"size": [40.0, 40.0]}, films={"cutoff": 0.1}, walls=walls,
                    hydrodynamics={"drag": "stokes"})  # fmt: skip
    assert ("no films at the start" in report(apart)) == reported


def test_a_pull_is_reported_with_the_time_in_which_it_separates_two_spheres():
    rows = {name: value for name, value, _ in SOFT.summary(two(1e-3))}
    assert rows["reduced force"] == "0.001"
    assert rows["spheres"] == "2"
    assert rows["narrowest gap"] == "10 mm"
    wanted = passage_time(SoftPair(1.0, 1.0, 1.0), 1e-3, 0.01, 1.0)
    assert float(rows["separation time"].removesuffix(" s")) == pytest.approx(wanted, rel=0.01)


@pytest.mark.long
def test_a_load_that_grows_and_waves_and_walls_count():
    assert expected(two(1e-3, protocol=[{"time": 0.0}, {"time": 1.0, "load": 3.0}])).force == pytest.approx(3e-3)
    stressed = packing(protocol=[{"time": 0.0, "shear_stress": 2e-4, "normal_stress": 1e-3}])
    found = expected(stressed)
    assert found.force == pytest.approx(1e-3 * 2.0 * found.pair.radius)
    assert "stress" in found.source
    walled = packing(walls=[{"side": "bottom"}, {"side": "top", "pressure": 2e-3}])
    assert expected(walled).force == pytest.approx(2e-3 * 2.0 * found.pair.radius)


@pytest.mark.long
def test_spheres_filled_in_closer_than_they_fit_press_as_they_then_do():
    squeezed = packing(filled=0.8, protocol=[{"time": 0.0}, {"time": 4.0, "scale": math.sqrt(0.8 / 0.9)}])
    found = expected(squeezed)
    assert found.source.startswith("compression")
    assert found.force == pytest.approx(pressed_force(found.pair, 0.9, 2))
    last = list(simulate(squeezed))[-1].numbers
    assert last["volume_fraction"] == pytest.approx(0.9)
    # Two of them press with twice the mean at the most.
    assert 1.0 < last["largest_compression"] / found.force < 4.0


def test_a_sheared_film_thins_until_the_surfaces_yield():
    """A short strain leaves the gap as it is; a long one squeezes the film, whatever the gap at the start."""
    pair = SoftPair(1.0, 1.0, 1e-3)
    assert sheared_force(pair, 0.01, 1e-6, 1e-6) == pytest.approx(1.5 * math.pi * 1e-3 / 0.01 * 2e-6, rel=1e-3)
    long = [sheared_force(pair, gap, 1e-2, 10.0) for gap in (1e-4, 0.01, 0.3)]
    crossing = (1.5 * math.pi * 1e-5 / math.sqrt(3.0)) ** 0.4
    assert long == pytest.approx([2.0 * math.sqrt(3.0) * crossing**1.5] * 3, rel=1e-12)
    assert long[0] == pytest.approx(1.5 * math.pi * 1e-3 / crossing * 2e-2)
    assert "shear" in expected(packing(protocol=[{"time": 0.0, "shear_rate": 1.0}])).source


@pytest.mark.parametrize(
    ("films", "says"),
    [({"tangential_law": "secant"}, "'potential'"), ({"tension_law": "symmetric"}, "'gap'"),
     ({"tension_law": "cavitation", "cavitation_pressure": 0.5}, "tenth of the modulus")],
)  # fmt: skip
def test_laws_that_fail_in_a_flow_are_doubted_where_the_strain_is_large(films, says):
    for strain, doubted in ((0.1, False), (2.0, True)):
        scene = packing(films=films, protocol=[{"time": 0.0}, {"time": 4.0, "strain": strain}])
        assert (says in report(scene)) == doubted


def test_nothing_is_foreseen_where_nothing_is_done():
    scene = packing()
    parameters, state = begun(scene)
    assert forces(scene, parameters, typical_pair(scene, parameters, state).pair, 0.02) == {}
    assert "force" not in {name for name, _, _ in SOFT.summary(scene)}


@pytest.mark.parametrize(
    ("scene", "says"),
    [
        (lambda: packing(radii=(1.0,), count=36, filled=0.75), "crystallize"),
        (lambda: two(0.1), "Hertz's law"),
        (lambda: two(1e-8), "rounding"),
        (lambda: two(1e-3, films={"friction": "coulomb", "roughness": 1e-3}), "no contact friction"),
        (lambda: two(1e-3, films={"friction": "coulomb", "roughness": 0.2}), "tips"),
        (
            lambda: two(1e-3, long_range_forces={"law": "steric", "steric_strength": 1e-6, "steric_length": 0.2}),
            "bear each other",
        ),
    ],
)
def test_what_may_not_be_meant_is_reported(scene, says):
    assert says in report(scene())


def test_what_is_usual_is_not_doubted():
    assert report(packing(rotation=True)) == ""
    assert "spheres do not rotate" in report(packing())
    assert report(packing(radii=(1.0,), count=20, filled=0.75, rotation=True)) == ""
    assert report(two(1e-3)) == ""


def test_the_strain_of_a_protocol_is_summed():
    parameters = SOFT.parameters(packing(protocol=[{"time": 0.0}, {"time": 4.0, "strain": 0.1}]))
    assert strain_of(parameters, 4.0) == pytest.approx(0.1)
    assert strain_of(parameters, 1.0) == pytest.approx(0.025)


@pytest.mark.parametrize("filled", [0.7, 0.8])
@pytest.mark.parametrize("strain", [0.03, 0.1, 1.0])
def test_the_number_of_steps_is_predicted_within_a_factor_of_three(filled, strain):
    scene = packing(filled=filled, protocol=[{"time": 0.0}, {"time": 4.0, "strain": strain}])
    assert_predicted(scene)


@pytest.mark.long
@pytest.mark.parametrize("strain", [0.1, 1.0])
def test_the_number_of_steps_of_a_flow_is_predicted_within_a_factor_of_three(strain):
    assert_predicted(rheology.sheared(40, 1, [{"time": 0.0, "shear_rate": 0.25}], strain / 0.25, 1))


def assert_predicted(scene):
    numbers = list(simulate(scene))[-1].numbers
    assert 1 / 3 < steps_of(scene, SOFT.parameters(scene)) / (numbers["time_steps"] + numbers["rejected_steps"]) < 3


def test_a_sine_strains_by_four_amplitudes_a_cycle():
    wave = {"frequency": 0.5, "amplitude": 0.01}
    parameters = SOFT.parameters(packing(protocol=[{"time": 0.0, "oscillation": wave}]))
    assert strain_of(parameters, 4.0) == pytest.approx(2 * 4 * 0.01)


@pytest.mark.parametrize(("rate", "measured"), [(0.025, 0.14), (0.25, 0.18), (2.5, 0.27), (25.0, 0.42)])
def test_deflections_beyond_hertzs_law_are_foreseen(rate, measured):
    scene = rheology.scene_of(rate, 1)
    parameters = SOFT.parameters(scene)
    typical = typical_pair(scene, parameters, SOFT.start(scene, parameters))
    assert largest_deflection(scene, parameters, typical) == pytest.approx(measured, rel=0.5)
    assert any("beyond the range of Hertz's law" in row[2] for row in doubts(scene, parameters, typical))
