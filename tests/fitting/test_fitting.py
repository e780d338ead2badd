"""Fits recover the parameters of tracks, with correct uncertainties, and report undetermined parameters."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

import ecume
from ecume.cli import app
from ecume.cli.fits import _cells
from ecume.errors import BadInput
from ecume.fitting import Camera, Tracks, read_tracks
from ecume.fitting.estimation import Estimate, certainty, positions_at, simulated, solved
from ecume.fitting.parameters import free_parameters
from ecume.fitting.tracks import matched
from ecume.scenes.load import load_scene
from ecume.scenes.schema import to_plain
from ecume.trajectories.frame import Frame

BEADS = """
model = "floating"
duration = "0.6 s"
frame_every = "20 ms"
[liquid]
density = 998.0
viscosity = "{viscosity} mPa*s"
surface_tension = "72.8 mN/m"
[[particles]]
radius = "1.2 mm"
density = 1300.0
contact_angle = "{angle} deg"
positions = [["-4 mm", "0 mm"], ["4 mm", "1 mm"]]
"""
NOISE = 3e-6
CSV = "t,x,y,id\n0,0.001,0.002,a\n0.5,0.0015,0.002,a\n1,0.002,0.002,a\n0,0.01,0,b\n1,0.009,0,b\n"
TRACKPY = (
    "y,x,mass,size,frame,particle\n100,50,1.5,2,0,3.0\n100,75,1.5,2,5,3.0\n100,100,1.5,2,10,3.0\n"
    "0,500,1,1,0,4\n0,450,1,1,10,4\n"
)
TRACKMATE = """LABEL,ID,TRACK_ID,QUALITY,POSITION_X,POSITION_Y,POSITION_Z,POSITION_T,FRAME,RADIUS
Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame,R
Label,Spot ID,Track ID,Quality,X,Y,Z,T,Frame,R
,,,(quality),(micron),(micron),(micron),(sec),,(micron)
ID7,7,0,3.1,1000,2000,0,10.0,0,5
ID8,8,0,3.1,1500,2000,0,10.5,5,5
ID9,9,0,3.1,2000,2000,0,11.0,10,5
ID1,1,1,3.1,10000,0,0,10.0,0,5
ID2,2,1,3.1,9000,0,0,11.0,10,5
ID3,3,,3.1,1,1,0,11.0,10,5
"""
EXPORTED = (
    "frame,time [s],particle,position_x [m],position_y [m]\n0,0,0,0.001,0.002\n0,0,1,0.01,0\n"
    "1,0.5,0,0.0015,0.002\n2,1,0,0.002,0.002\n2,1,1,0.009,0\n"
)
FORMATS = {
    "plain": (CSV, Camera()),
    "with units": (CSV.replace("x,y", "x [m],y (m)").replace("t,", "t [s],", 1), Camera(pixel=7.0)),
    "semicolons": (CSV.replace(",", ";"), Camera()),
    "decimal commas": (CSV.replace(",", ";").replace(".", ","), Camera()),
    "decimal commas and tabs": (CSV.replace(",", "\t").replace(".", ","), Camera()),
    "lost now and then": (CSV + "0.5,,nan,b\n", Camera()),
    "trackpy": (TRACKPY, Camera(pixel=2e-5, rate=10.0)),
    "TrackMate": (TRACKMATE, Camera()),
    "TrackMate in pixels": (TRACKMATE.replace("micron", "pixel"), Camera(pixel=1e-6)),
    "ecume export": (EXPORTED, Camera()),
}


def written(folder, text):
    path = folder / "tracks.csv"
    path.write_text(text)
    return path


def beads(*, viscosity=5.0, angle=100.0):
    return load_scene(BEADS.format(viscosity=viscosity, angle=angle))


@pytest.fixture(scope="module")
def tracks():
    """Tracks of beads that drift toward each other, with noise."""
    frames = list(ecume.simulate(beads()))
    chance = np.random.default_rng(1)
    position = np.stack([frame.arrays["position"] for frame in frames])
    return Tracks(("1", "2"), np.array([frame.time for frame in frames]), chance.normal(position, NOISE))


@pytest.mark.parametrize(("text", "camera"), FORMATS.values(), ids=FORMATS)
def test_each_programs_table_is_read_in_meters_and_seconds(tmp_path, text, camera):
    found = read_tracks(written(tmp_path, text), camera)
    assert found.names in (("a", "b"), ("3", "4"), ("0", "1"))
    np.testing.assert_allclose(found.times, [0.0, 0.5, 1.0], atol=1e-12)
    np.testing.assert_allclose(found.position[:, 0], [[1e-3, 2e-3], [1.5e-3, 2e-3], [2e-3, 2e-3]], rtol=1e-12)
    np.testing.assert_allclose(found.position[[0, 2], 1], [[0.01, 0.0], [0.009, 0.0]], rtol=1e-12)
    assert np.isnan(found.position[1, 1]).all()


def test_the_origin_is_in_the_units_of_the_table(tmp_path):
    found = read_tracks(written(tmp_path, TRACKPY), Camera(pixel=2e-5, rate=10.0, origin=(50.0, 100.0)))
    np.testing.assert_allclose(found.position[0], [[0.0, 0.0], [9e-3, -2e-3]], atol=1e-15)


@pytest.mark.parametrize(
    ("text", "camera", "why"),
    [
        ("", Camera(), "is empty"),
        ("x,y,t\n1,2,3\n", Camera(), "there are only 1 instants"),
        ("x,y,object\n1,2,3\n", Camera(), "missing column"),
        (TRACKPY, Camera(pixel=1e-5), "give the frame rate"),
        (TRACKPY, Camera(rate=25.0), "give the size of a pixel"),
        (CSV, Camera(rate=25.0), "line 3: the time 0.5 is no number of frames; omit --rate"),
        (TRACKMATE.replace("(micron)", "").replace("(sec)", ""), Camera(), "positions have no unit; give it"),
        (CSV.replace(",", ";").replace("0.0015", "1.000,5"), Camera(), "line 3, x: got '1.000,5'"),
        (CSV.replace("0.0015", "near"), Camera(), "line 3, x: got 'near'; expected a number"),
        (CSV.replace("0.0015", "inf"), Camera(), "line 3, x: got 'inf'"),
        (CSV.replace("1,0.009,0,b", "0,0.009,0,b"), Camera(), "object b is in two places at t = 0 s"),
        (CSV.replace("x,y", "x [kg],y [kg]"), Camera(), "measures mass, expected length"),
        ("t,x,y,id\n0,1,1,a\n1,1,1,a\n", Camera(), "only 2 instants"),
        ("t,x,y,id\n0,1\n", Camera(), "line 2: 2 cells"),
        ('t,x,y,id\n0,"1\n', Camera(), "line 2"),
    ],
)
def test_a_table_that_cannot_be_read_is_refused_in_a_line(tmp_path, text, camera, why):
    with pytest.raises(BadInput, match=why) as reported:
        read_tracks(written(tmp_path, text), camera)
    assert "\n" not in str(reported.value)


def test_a_short_name_means_the_particles_before_the_liquid():
    plain = to_plain(beads())
    free = free_parameters(plain, ["density", "viscosity", "liquid.density", "contact_angle"])
    assert [one.paths for one in free] == [
        (("particles", 0, "density"),),
        (("liquid", "viscosity"),),
        (("liquid", "density"),),
        (("particles", 0, "contact_angle"),),
    ]
    assert [one.unit for one in free] == ["kg/m^3", "Pa*s", "kg/m^3", "rad"]


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("viscocity", "did you mean viscosity"),
        ("title", "got ''; expected a parameter that is a number"),
        ("liquid.gas_density", "starts at 0"),
        ("interaction.law", "got 'capillary'; expected a parameter that is a number"),
        ("count", "got 2; expected a parameter that is a number, and no whole one"),
    ],
)
def test_what_cannot_be_fitted_is_refused(name, why):
    with pytest.raises(BadInput, match=why):
        free_parameters(to_plain(beads()), [name])


def test_no_coordinate_leaves_what_is_possible():
    angle, viscosity = free_parameters(to_plain(beads()), ["contact_angle", "viscosity"])
    for free, value in ((angle, 1.0), (viscosity, 3e-3)):
        assert free.at(free.coordinate(value)) == pytest.approx(value, rel=1e-12)
        step = (math.log(free.at(free.coordinate(value) + 1e-6)) - math.log(value)) / 1e-6
        assert free.steepness(value) == pytest.approx(step, rel=1e-5)
    assert 0.0 <= angle.at(-1e9) < angle.at(1e9) <= math.pi
    assert 0.0 < viscosity.at(-1e9) < viscosity.at(1e9) < math.inf


def test_least_squares_and_errors_of_a_straight_line_are_those_of_the_textbook():
    """The variance of a slope is s^2/S, whether or not the other coefficient is requested as well."""
    t = np.linspace(0.0, 1.0, 30)
    y = 2.0 + 3.0 * t + np.random.default_rng(2).normal(0.0, 0.1, 30)
    found = solved(lambda at: at[0] * t + at[1] - y, np.zeros(2))
    np.testing.assert_allclose(found.coordinates, np.polyfit(t, y, 1), rtol=1e-6)
    spread = np.sum((t - t.mean()) ** 2)
    assert found.noise == pytest.approx(np.sqrt(np.sum(found.residuals**2) / 28), rel=1e-12)
    assert certainty(found, 1).error_of(np.ones(1)) == pytest.approx(found.noise / np.sqrt(spread), rel=1e-4)
    assert certainty(found, 2).error_of(np.array([1.0, 0.0])) == pytest.approx(found.noise / np.sqrt(spread), rel=1e-4)
    assert certainty(found, 2).quantile == pytest.approx(2.048, abs=1e-3)  # Student's table, 28 degrees of freedom


def test_what_two_parameters_only_do_together_is_undetermined_apart():
    t = np.linspace(0.0, 1.0, 30)
    y = 5.0 * t + np.random.default_rng(3).normal(0.0, 0.1, 30)
    sure = certainty(solved(lambda at: (at[0] + at[1]) * t - y, np.zeros(2)), 2)
    assert sure.determined.tolist() == [True, False]
    assert sure.error_of(np.array([1.0, 0.0])) == math.inf
    assert 0.0 < sure.error_of(np.array([1.0, 1.0])) < 0.1


def test_positions_between_frames_are_exact_for_cubics():
    def frame(t):
        return Frame(t, {"position": np.array([[t**3, t]]), "velocity": np.array([[3 * t**2, 1.0]])}, {}, {})

    frames = [frame(t) for t in (0.0, 0.5, 1.0)]
    at = np.array([0.1, 0.7, 1.0])
    np.testing.assert_allclose(positions_at(frames, at)[:, 0], np.stack([at**3, at], axis=1), atol=1e-14)
    bare = [one._replace(arrays={"position": one.arrays["position"]}) for one in frames]
    np.testing.assert_allclose(positions_at(bare, np.array([0.25]))[0, 0], [0.0625, 0.25])


@pytest.mark.long
def test_positions_do_not_jump_at_the_borders_of_a_periodic_cell():
    """A float that drifts at 20 mm/s through a cell of 70 mm."""
    cell = """[cell]\nsize = ["70 mm", "70 mm"]\n[flow]\nvelocity = ["20 mm/s", 0]\n[liquid]"""
    scene = BEADS.format(viscosity=1, angle=80).replace("[liquid]", cell).replace("0.6 s", "1 s")
    one = (
        scene.partition("positions")[0] + 'density = 600.0\npositions = [["60 mm", "20 mm"]]\nvelocity = ["20 mm/s", 0]'
    )
    at = np.linspace(0.0, 1.0, 5)
    found = simulated(load_scene(one.replace("density = 1300.0\n", "")), at)
    np.testing.assert_allclose(found[:, 0], np.stack([0.06 + 0.02 * at, np.full(5, 0.02)], axis=1), rtol=1e-9)


def test_a_track_is_of_the_particle_that_starts_where_it_does():
    there = Frame(0.0, {"position": np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])}, {}, {})
    moved = there.arrays["position"][[2, 0, 1]] + 5.0
    found = matched(Tracks(("a", "b", "c"), np.zeros(1), moved[None]), there, centered=True)
    assert found.names == ("b", "c", "a")
    np.testing.assert_array_equal(found.position[0], there.arrays["position"] + 5.0)
    with pytest.raises(BadInput, match="2 tracks and 3 particles"):
        matched(Tracks(("a", "b"), np.zeros(1), moved[None, :2]), there, centered=True)


@pytest.mark.long
@pytest.mark.compiled
def test_angle_viscosity_and_charge_are_found_again_within_their_intervals(tracks):
    found = ecume.fit(tracks, beads(viscosity=3.0, angle=80.0), ["contact_angle", "viscosity"])
    (charge,) = (one for one in found.derived if one.name == "charge")
    (true,) = (one.value for one in ecume.fit(tracks, beads(), ["contact_angle"], start="scene").derived[:1])
    angle, viscosity = found.estimates
    for one, truth in ((angle, math.radians(100.0)), (viscosity, 5e-3)):
        assert one.low < truth < one.high
        assert 1.0 < one.high / one.low < 1.2
    assert charge.low < charge.value < charge.high
    assert charge.value == pytest.approx(true, rel=0.05)
    assert found.noise == pytest.approx(NOISE, rel=0.15)
    assert found.remarks == []


@pytest.mark.long
@pytest.mark.compiled
def test_angle_and_density_are_not_distinguished_and_the_known_combination_is_reported(tracks):
    found = ecume.fit(tracks, beads(), ["contact_angle", "density", "viscosity"])
    assert not any(one.determined for one in found.estimates)
    known = {one.name: one.determined for one in found.derived}
    assert known == {"charge": False, "pull/mass": True, "friction/mass": True, "pull/friction": True}
    assert "determine 2 of 3 combinations" in found.remarks[0]


@pytest.mark.long
@pytest.mark.compiled
def test_the_verb_writes_scene_numbers_and_figure(tmp_path, tracks, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beads.toml").write_text(BEADS.format(viscosity=5.0, angle=100.0))
    rows = [
        f"{px / 2e-5},{py / 2e-5},{frame},{name}"
        for frame, there in enumerate(tracks.position)
        for name, (px, py) in zip(tracks.names, there, strict=True)
    ]
    written(tmp_path, "x,y,frame,particle\n" + "\n".join(rows))
    words = ["fit", "tracks.csv", "--scene", "beads.toml", "--free", "viscosity", "--pixel", "20 um", "--rate", "50"]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    assert "viscosity" in done.stdout
    reported = json.loads((tmp_path / "fits/tracks/fit.json").read_text())
    low, high = reported["estimates"][0]["interval"]
    assert abs(reported["estimates"][0]["value"] - 5e-3) < high - low < 1e-3
    assert load_scene(tmp_path / "fits/tracks/fitted.toml").liquid.viscosity == reported["estimates"][0]["value"]
    assert (tmp_path / "fits/tracks/residuals.png").stat().st_size > 10_000


def test_angles_are_printed_in_degrees():
    name, value, interval, unit = _cells(Estimate("contact_angle", 0.5 * math.pi, 1.5, 1.6, "rad"))
    assert (name, unit) == ("contact_angle", "deg")
    assert float(value) == pytest.approx(90.0)
    assert float(interval.split()[0]) == pytest.approx(math.degrees(1.5), rel=1e-3)


@pytest.mark.parametrize("out", ["taken", "taken/fits"])
def test_results_that_cannot_be_kept_are_refused_before_the_fit(out, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("ecume.fitting.fit", lambda *_, **__: pytest.fail("computed"))
    (tmp_path / "beads.toml").write_text(BEADS.format(viscosity=5.0, angle=100.0))
    written(tmp_path, "x,y,t,id\n0,0,0,1\n1,0,0.1,1\n2,0,0.2,1\n3,0,0.3,1\n")
    (tmp_path / "taken").write_text("mine")
    words = ["fit", "tracks.csv", "--scene", "beads.toml", "--free", "viscosity", "--pixel", "20 um", "-o", out]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 4, done.output
    assert "Not a directory" in done.stderr
    assert (tmp_path / "taken").read_text() == "mine"
