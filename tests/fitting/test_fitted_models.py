"""All models with positions in 2D can be fitted, and other scenes are refused."""

import numpy as np
import pytest
from typer.testing import CliRunner

import ecume
from ecume.cli import app
from ecume.errors import BadInput
from ecume.fitting import Tracks, picked
from ecume.fitting.estimation import Problem, outlier, swapped
from ecume.fitting.parameters import Free, free_parameters, with_values
from ecume.fitting.tracks import start_at
from ecume.scenes.load import load_scene
from ecume.scenes.schema import from_plain, to_plain

pytestmark = pytest.mark.sampled(2)

SETTLING = """
model = "tracers"
duration = "{duration}"
frame_every = "10 ms"
[liquid]
density = 1000.0
viscosity = "{viscosity} mPa*s"
[[particles]]
radius = "0.2 mm"
density = 1200.0
positions = [["1 cm", "5 cm"], ["2 cm", "6 cm"]]
{more}
"""
PRESSED = """
model = "soft"
duration = "4 s"
frame_every = "0.2 s"
[liquid]
viscosity = 1e-6
[[particles]]
radius = 1.0
modulus = 1.0
positions = [[-1.0005, 0.0]]
force = [{left}, 0.0]
[[particles]]
radius = 1.0
modulus = 1.0
positions = [[1.0005, 0.0]]
force = [{right}, 0.0]
[films]
prefactors = "paper"
"""


def settling(viscosity=5.0, duration="0.3 s", more=""):
    return load_scene(SETTLING.format(viscosity=viscosity, duration=duration, more=more))


def pressed(force=1e-6):
    return load_scene(PRESSED.format(left=-force, right=force))


def tracks_of(scene, noise):
    frames = list(ecume.simulate(scene))
    position = np.stack([frame.arrays["position"] for frame in frames])
    times = np.array([frame.time for frame in frames])
    return Tracks(("a", "b"), times, np.random.default_rng(4).normal(position, noise))


@pytest.mark.compiled
def test_the_viscosity_is_found_in_which_spheres_settle():
    found = ecume.fit(tracks_of(settling(), 1e-6), settling(viscosity=3.0), ["viscosity"])
    (viscosity,) = found.estimates
    assert viscosity.low < 5e-3 < viscosity.high < 1.02 * viscosity.low
    assert found.noise == pytest.approx(1e-6, rel=0.15)
    assert found.remarks == []


@pytest.mark.compiled
def test_of_creeping_spheres_the_settling_speed_is_known_and_not_viscosity_and_density_apart():
    thick = settling(
        viscosity=1000.0, more="[integration]\nintegrator = 'overdamped'\n[hydrodynamics]\ndrag = 'stokes'"
    )
    found = ecume.fit(tracks_of(thick, 1e-8), thick, ["viscosity", "particles[0].density"])
    assert not any(one.determined for one in found.estimates)
    (speed,) = found.derived
    assert speed.name == "settling speed"
    # Stokes: 2/9 (rho - rho_0) g R^2 / eta
    assert speed.low < 2.0 / 9.0 * 200.0 * 9.81 * 0.2e-3**2 / 1.0 < speed.high
    assert "determine 1 of 2 combinations" in found.remarks[0]


@pytest.mark.long
@pytest.mark.compiled
def test_the_force_is_found_that_pulls_soft_spheres_apart():
    found = ecume.fit(tracks_of(pressed(), 1e-6), pressed(force=2e-6), ["force"], start="scene")
    (force,) = found.estimates
    assert force.unit == "N"
    assert force.low < 1e-6 < force.high < 1.02 * force.low
    one, other = (species.force for species in found.scene.particles)
    assert -one[0] == other[0] == pytest.approx(force.value, rel=1e-12)
    assert one[1] == other[1] == 0.0


def test_a_vector_is_fitted_by_its_size():
    plain = to_plain(pressed(force=3e-6))
    (force,) = free_parameters(plain, ["force"])
    assert (force.value, force.unit) == (3e-6, "N")
    with_values(plain, [force], [1e-6])
    assert [list(species["force"]) for species in plain["particles"]] == [[-1e-6, 0.0], [1e-6, 0.0]]
    (component,) = free_parameters(plain, ["particles[0].force[0]"])
    assert component.at(component.coordinate(component.value)) == pytest.approx(-1e-6, rel=1e-12)


def test_particles_of_each_model_start_where_they_were_seen():
    there = np.array([[0.1, 0.2], [3.0, 0.4]])
    for scene in (settling(), pressed()):
        started = from_plain(start_at(to_plain(scene), there, None))
        found = [place for species in started.particles for place in species.positions]
        np.testing.assert_array_equal(found, there)
    one = SETTLING.replace(', ["2 cm", "6 cm"]', "")
    plain = to_plain(load_scene(one.format(viscosity=1.0, duration="0.1 s", more="")))
    started = from_plain(start_at(plain, there[:1], np.array([[0.5, 0.0]])))
    assert started.particles[0].velocity == (0.5, 0.0)


@pytest.mark.parametrize(
    ("scene", "start", "why"),
    [
        (settling(), "moving", r"start with one velocity; write \[\[particles\]\] for each"),
        (pressed(), "moving", "soft spheres have no inertia"),
        (settling(more="[hydrodynamics]\nbrownian = true"), "scene", "the scene has Brownian motion"),
    ],
)
def test_what_cannot_be_fitted_along_is_reported(scene, start, why):
    tracks = Tracks(("a", "b"), np.arange(4.0), np.zeros((4, 2, 2)))
    with pytest.raises(BadInput, match=why):
        ecume.fit(tracks, scene, ["viscosity"], start=start)


def crossing():
    """Two objects that pass each other."""
    times = np.linspace(0.0, 1.0, 11)
    one = np.stack([times, 0.0 * times], axis=1)
    other = np.stack([1.0 - times, 0.0 * times + 0.5], axis=1)
    return Tracks(("a", "b"), times, np.stack([one, other], axis=1))


def test_names_that_are_exchanged_are_found_and_paths_that_cross_are_not():
    tracks = crossing()
    assert swapped(tracks) == []
    mixed = tracks.position.copy()
    mixed[7:] = mixed[7:, ::-1]
    output = swapped(tracks._replace(position=mixed))
    assert output == ["objects a, b seem to swap names at t = 0.7 s; correct the tracks"]
    mixed[3] = np.nan
    assert swapped(tracks._replace(position=mixed)) == output


def test_a_measurement_far_from_all_others_is_named():
    tracks = crossing()
    free = Free("x", (("liquid", "viscosity"),), 1.0, "Pa*s")
    problem = Problem({}, [free], tracks, "scene", 1.0, tracks.position[0], np.zeros((2, 2)))
    left = np.random.default_rng(1).normal(0.0, 1e-6, tracks.position.shape)
    assert outlier(problem, left) == []
    left[4, 1] = 2e-3, 0.0
    assert outlier(problem, left) == ["object b is 2 mm off at t = 0.4 s: more than noise; delete such lines"]
    left[:5, 1] += 1e-3  # a quarter of all: it is the scene that is wrong
    assert outlier(problem, left) == []


def test_objects_are_picked_by_name():
    tracks = crossing()
    found = picked(tracks, ["b"])
    assert found.names == ("b",)
    np.testing.assert_array_equal(found.position, tracks.position[:, 1:])
    late = tracks.position.copy()
    late[:2, 1] = np.nan
    found = picked(tracks._replace(position=late), ["b"])
    assert found.times[0] == 0.0
    assert len(found.times) == 9
    late[:9, 1] = np.nan
    with pytest.raises(BadInput, match="b: 2 observations; expected 3 or more"):
        picked(tracks._replace(position=late), ["b"])
    with pytest.raises(BadInput, match="no object 'c'; known: a, b"):
        picked(tracks, ["c"])


def test_tracks_that_were_lost_and_found_again_are_reported(tmp_path):
    (tmp_path / "tr.toml").write_text(SETTLING.format(viscosity=1.0, duration="0.1 s", more=""))
    seen = [(t / 100, x, name) for t in range(4) for x, name in ((0.01, "a"), (0.02, "b"), (0.9, "c"))]
    rows = "\n".join(f"{t},{x},0.05,{name}" for t, x, name in seen)
    (tmp_path / "tracks.csv").write_text(f"t,x,y,id\n{rows}\n")
    words = ["fit", str(tmp_path / "tracks.csv"), "--scene", str(tmp_path / "tr.toml"), "--free", "viscosity"]
    output = CliRunner().invoke(app, words)
    assert output.exit_code == 2
    assert "2 particles in the scene; expected the same number; name those that count (--only)" in output.stderr
    unknown = CliRunner().invoke(app, [*words, "--only", "a,d"])
    assert "no object 'd'" in unknown.stderr
