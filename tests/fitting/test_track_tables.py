"""Tables of tracks from video programs that write objects beside one another, or each into a file of its own."""

from pathlib import Path

import numpy as np
import pytest

import ecume
from ecume.errors import BadInput
from ecume.fitting import Camera, read_tracks

TIMES = np.arange(5) * 0.04
ONE = np.stack([0.007 + 0.001 * TIMES, np.full(5, 0.01)], axis=1)
OTHER = np.stack([0.013 - 0.002 * TIMES, np.full(5, 0.01)], axis=1)


def lines(columns, mark="\t", digits=".9g"):
    return "".join(mark.join(format(value, digits) for value in row) + "\n" for row in zip(*columns, strict=True))


def tracker(place):
    """A data table of Tracker: t, x, y, v, and empty columns."""
    return lines([TIMES, *place.T, np.zeros(5)]).replace("\n", "\t\t\n")


NAMED = "mass_A\t\t\t\nt\tx\ty\tv\n" + lines([TIMES, *ONE.T, np.zeros(5)])
BOTH = "\tmass_A\t\tmass_B\t\nt\tx\ty\tx\ty\n" + lines([TIMES, *ONE.T, *OTHER.T])
WIDE = "t,x_A,y_A,x_B,y_B\n" + lines([TIMES, *ONE.T, *OTHER.T], ",")
WIDE_MM = "t [s],x_A [mm],y_A [mm],x_B [mm],y_B [mm]\n" + lines([TIMES, *(1e3 * ONE.T), *(1e3 * OTHER.T)], ",")
MTRACKJ = " ,TID,PID,x [mm],y [mm],t [sec],I [val]\n" + "".join(
    f"{n},{tid},{n},{1e3 * x:.7g},{1e3 * y:.7g},{t:.3f},100\n"
    for tid, place in ((1, ONE), (2, OTHER))
    for n, (t, (x, y)) in enumerate(zip(TIMES, place, strict=True), 1)
)


@pytest.mark.parametrize(
    ("texts", "names"),
    [
        ([tracker(ONE), tracker(OTHER)], ("file0", "file1")),
        ([NAMED, NAMED.replace("mass_A", "mass_B")], ("mass_A", "mass_B")),
        ([NAMED, tracker(OTHER)], ("file1", "mass_A")),
        ([BOTH], ("mass_A", "mass_B")),
        ([WIDE], ("A", "B")),
        ([WIDE_MM], ("A", "B")),
        ([MTRACKJ], ("1", "2")),
    ],
)
def test_tables_of_video_programs_are_read(tmp_path, texts, names):
    files = [tmp_path / f"file{number}.txt" for number in range(len(texts))]
    for file, text in zip(files, texts, strict=True):
        file.write_text(text)
    found = read_tracks(files if len(files) > 1 else files[0])
    assert found.names == names
    assert found.times == pytest.approx(TIMES)
    left = int(np.argmin(found.position[0, :, 0]))
    if len(texts) == 1 or texts[0] != texts[1]:
        assert found.position[:, left] == pytest.approx(ONE, abs=1e-9)


def test_equal_names_in_two_files_are_two_objects(tmp_path):
    for name, place in (("one", ONE), ("two", OTHER)):
        (tmp_path / f"{name}.txt").write_text("mass_A\t\t\t\nt\tx\ty\tv\n" + lines([TIMES, *place.T, np.zeros(5)]))
    found = read_tracks([tmp_path / "one.txt", tmp_path / "two.txt"])
    assert found.names == ("mass_A", "two: mass_A")
    assert found.position[:, 1] == pytest.approx(OTHER)


def test_a_table_of_something_else_is_refused(tmp_path):
    (tmp_path / "other.csv").write_text("a,b,c\n1,2,3\n")
    with pytest.raises(BadInput, match="expected x, y, t and id, or a table of trackpy, TrackMate, MTrackJ or Tracker"):
        read_tracks(tmp_path / "other.csv")


CASES = Path(__file__).parent / "cases"


@pytest.mark.compiled
@pytest.mark.parametrize(
    "files",
    [
        ["pointA.txt", "pointB.txt"],
        ["trackerA.txt", "trackerB.txt"],
        ["tracker_wide.csv"],
        ["mtrackj.csv"],
        ["trackmate.csv"],
        ["trackpy.csv"],
    ],
    ids=lambda files: files[0].partition(".")[0],
)
def test_student_tracks(files):
    """The same two beads as each program exports them: the viscosity is 10 mPa s, from a start of 20, with the drag of
    the simulation behind them.
    """
    camera = Camera(pixel=2e-5, rate=25.0) if files == ["trackpy.csv"] else Camera()
    tracks = read_tracks([CASES / file for file in files], camera)
    found = ecume.fit(tracks, CASES / "guess.toml", ["viscosity"])
    (viscosity,) = (one.value for one in found.estimates)
    assert viscosity == pytest.approx(0.00999, rel=2e-3)
