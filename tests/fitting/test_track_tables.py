"""Tables of tracks from video programs, with several objects side by side, or one object per file."""

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


@pytest.mark.long
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


def side_by_side(heads, mark, columns=(TIMES, 1e3 * ONE[:, 0], 1e3 * ONE[:, 1], 1e3 * OTHER[:, 0], 1e3 * OTHER[:, 1])):
    """A table in s and mm with two objects side by side."""
    text = mark.join(heads) + "\n" + lines(columns, mark)
    return text if mark == "," else text.replace(".", ",")


BESIDE = [
    ["t [s]", "x1 [mm]", "y1 [mm]", "x2 [mm]", "y2 [mm]"],
    ["t (s)", "X1 (mm)", "Y1 (mm)", "X2 (mm)", "Y2 (mm)"],
    ["time_s", "x_a [mm]", "y_a [mm]", "x_b [mm]", "y_b [mm]"],
    ["Time [s]", "a_x [mm]", "a_y [mm]", "b_x [mm]", "b_y [mm]"],
    ["Time [s]", "Trajectory 1/X [mm]", "Trajectory 1/Y [mm]", "Trajectory 2/X [mm]", "Trajectory 2/Y [mm]"],
]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
@pytest.mark.parametrize("mark", [",", ";", "\t"])
@pytest.mark.parametrize("heads", BESIDE)
def test_objects_beside_one_another_are_read_with_every_separator_and_encoding(heads, mark, encoding, tmp_path):
    for unit, scale in (("mm", 1e3), ("µm", 1e6)):
        columns = (TIMES, *(scale * ONE.T), *(scale * OTHER.T))
        named = [head.replace("mm", unit) for head in heads]
        (tmp_path / "beads.csv").write_bytes(side_by_side(named, mark, columns).encode(encoding))
        found = read_tracks(tmp_path / "beads.csv")
        assert found.times == pytest.approx(TIMES)
        assert found.position == pytest.approx(np.stack([ONE, OTHER], axis=1), abs=1e-9)


def in_rows(head, row):
    """A table with one object per line, in pixels of 20 µm and frames."""
    spots = [(who, n, *place) for who, track in ((1, ONE), (2, OTHER)) for n, place in enumerate(track / 20e-6)]
    return head + "".join(row(who, n, x, y) for who, n, x, y in spots)


IN_ROWS = {
    "manual": in_rows(
        " \tTrack n°\tSlice n°\tX\tY\tDistance\tVelocity\tPixel Value\n",
        lambda who, n, x, y: f"0\t{who}\t{n + 1}\t{x:.9g}\t{y:.9g}\t-1\t-1\t255\n",
    ),
    "mosaic": in_rows(",Trajectory,Frame,x,y,z,m0,m1\n", lambda who, n, x, y: f"0,{who},{n},{x:.9g},{y:.9g},0,1,1\n"),
    "deeplabcut": "scorer,net,net,net,net,net,net\nbodyparts,1,1,1,2,2,2\ncoords,x,y,likelihood,x,y,likelihood\n"
    + lines([np.arange(5), *(ONE.T / 20e-6), np.ones(5), *(OTHER.T / 20e-6), np.ones(5)], ","),
    "individuals": "scorer,net,net,net,net\nindividuals,1,1,2,2\nbodyparts,head,head,head,head\ncoords,x,y,x,y\n"
    + lines([np.arange(5), *(ONE.T / 20e-6), *(OTHER.T / 20e-6)], ","),
}


@pytest.mark.parametrize("kind", IN_ROWS)
@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
def test_tables_of_tracking_programs_in_pixels_and_frames_are_read(kind, encoding, tmp_path):
    (tmp_path / "beads.txt").write_bytes(IN_ROWS[kind].encode(encoding))
    found = read_tracks(tmp_path / "beads.txt", Camera(pixel=20e-6, rate=25.0))
    assert found.times == pytest.approx(TIMES)
    assert found.position == pytest.approx(np.stack([ONE, OTHER], axis=1), abs=1e-9)


def test_a_unit_behind_an_underscore_is_no_object(tmp_path):
    (tmp_path / "bead.csv").write_text("t_s,x_mm,y_mm\n" + lines([TIMES, *(1e3 * ONE.T)], ","))
    found = read_tracks(tmp_path / "bead.csv")
    assert found.names == ("bead",)
    assert found.position[:, 0] == pytest.approx(ONE, abs=1e-9)


@pytest.mark.parametrize("more", ["x velocity", "v_x", "x_v"])
def test_velocities_beside_positions_are_no_objects(more, tmp_path):
    """As Logger Pro and Tracker write them."""
    for name, track in (("one", ONE), ("other", OTHER)):
        heads = f"Time (s),X (m),Y (m),{more},{more.replace('x', 'y')}\n"
        (tmp_path / f"{name}.csv").write_text(heads + lines([TIMES, *track.T, TIMES, TIMES], ","))
    found = read_tracks([tmp_path / "one.csv", tmp_path / "other.csv"])
    assert found.names == ("one", "other")
    assert found.position == pytest.approx(np.stack([ONE, OTHER], axis=1), abs=1e-9)


def test_columns_between_blanks_are_read(tmp_path):
    (tmp_path / "bead.txt").write_text("# t x y\n" + lines([TIMES, *ONE.T], "   "))
    assert read_tracks(tmp_path / "bead.txt").position[:, 0] == pytest.approx(ONE, abs=1e-9)


def test_a_file_that_is_no_text_is_refused(tmp_path):
    (tmp_path / "beads.csv").write_bytes(b"PK\x03\x04\x14\x00\xff")
    with pytest.raises(BadInput, match="is not UTF-8 text"):
        read_tracks(tmp_path / "beads.csv")


SPELLINGS = {
    "tabs": "{rows}",
    "semicolons": "{rows}",
    "blanks": "{rows}",
    "German": "Zeit in s;x in mm;y in mm\n{rows}",
    "French": "temps (s);x (mm);y (mm)\n{rows}",
    "slashes": "t/s;x/mm;y/mm\n{rows}",
    "of Excel": "sep=;\nt [s];x [mm];y [mm]\n{rows}",
}


@pytest.mark.parametrize("kind", SPELLINGS)
def test_decimal_commas_and_heads_in_other_languages_are_read(kind, tmp_path):
    bare = SPELLINGS[kind] == "{rows}"
    mark = {"tabs": "\t", "blanks": "  "}.get(kind, ";")
    rows = lines([TIMES, *((1.0 if bare else 1e3) * ONE.T)], mark, ".7f").replace(".", ",")
    (tmp_path / "bead.csv").write_text(SPELLINGS[kind].format(rows=rows))
    found = read_tracks(tmp_path / "bead.csv")
    assert found.names == ("bead",)
    assert found.position[:, 0] == pytest.approx(ONE, abs=1e-7)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (
            "id;frame;x;y\n" + "".join(f"1;{998 + n:,};{n};{n}\n" for n in range(5)),
            "may mean '1000' or '1.000'",
        ),
        ("id,t,x,y\n" + "".join(f'1,{n}.5,"1,{n}00",2\n' for n in range(3)), "may mean '1000' or '1.000'"),
        ("id,t,x,y,x\n" + "1,0,0,0,1\n" * 3, "has the column 'x' 2 times"),
        ("id,t,x [px],y [px],x [mm],y [mm]\n" + "1,0,0,0,0,0\n" * 3, "has the column 'x [px]' 2 times"),
        ("t,x1,y1,x1,y1\n" + "0,0,0,0,0\n" * 3, "has the column 'x1' twice"),
        ("t,x1 [mm],y1 [mm],x2 [cm],y2 [cm]\n" + "0,0,0,0,0\n" * 3, "'x2 [cm]' and 'y2 [cm]' have other units than"),
        ("id,t,x [mm],y\n" + "1,0,0,0\n" * 3, "expected a unit in both"),
    ],
    ids=[
        "thousands",
        "thousands beside points",
        "two columns x",
        "two units of x",
        "one object twice",
        "units of objects",
        "one unit",
    ],
)
def test_a_table_with_two_meanings_is_refused(text, fault, tmp_path):
    (tmp_path / "beads.csv").write_text(text)
    with pytest.raises(BadInput) as refused:
        read_tracks(tmp_path / "beads.csv", Camera(pixel=20e-6, rate=25.0))
    assert fault in str(refused.value)


@pytest.mark.parametrize(
    "head",
    ["frame,y [px],x [px],mass,frame,particle", "Frame,Time (s),X (m),Y (m)", "image,t,x1 (m),y1 [m],x2 [m],y2 (m)"],
    ids=["trackpy, indexed by frame", "frames and times", "pictures and times"],
)
def test_columns_beside_those_that_are_used_are_no_fault(head, tmp_path):
    names = head.lower().split(",")
    cells = {"frame": "{0}", "t": "{1}", "time (s)": "{1}", "image": "{0}.tif", "particle": "7", "mass": "9"}
    rows = [",".join(cells.get(name, "0.5").format(n, 0.04 * n) for name in names) for n in range(4)]
    (tmp_path / "bead.csv").write_text("\n".join([head, *rows]) + "\n")
    found = read_tracks(tmp_path / "bead.csv", Camera(1.0, 25.0) if "particle" in head else Camera())
    assert found.times == pytest.approx(0.04 * np.arange(4))
    assert (found.position == 0.5).all()


def test_a_decimal_comma_shows_what_others_in_a_table_mean(tmp_path):
    """Programs for tables omit zeros at the end: 1,500 and 2,000 become 1,5 and 2."""
    (tmp_path / "bead.csv").write_text("t;x;y\n0;1,125;0,5\n1;2;0,25\n2;2,875;0,125\n")
    assert read_tracks(tmp_path / "bead.csv").position[:, 0, 0].tolist() == [1.125, 2.0, 2.875]


def test_many_objects_at_different_instants_are_refused_before_there_is_memory_for_them(tmp_path):
    (tmp_path / "beads.csv").write_text("id,t,x,y\n" + "".join(f"{n},{n},0,0\n" for n in range(5000)))
    with pytest.raises(BadInput, match="5000 objects at 5000 instants are more than 20000000 places"):
        read_tracks(tmp_path / "beads.csv")


@pytest.mark.parametrize("marks", [("", ""), ("(", ")"), ("[", "]")])
@pytest.mark.parametrize(
    ("above", "head", "units", "columns"),
    [
        ("", "t;x;y;id", "s;mm;mm;", "1e0;{0};{1};A"),
        ("", "t;x;y;id", "ms;mm;mm;-", "1e3;{0};{1};A"),
        ("mass A;;\n", "t;x;y", "s;cm;cm", "1e0;{0};{1}"),
        ("", "t;xA;yA;xB;yB", "s;mm;mm;mm;mm", "1e0;{0};{1};{2};{3}"),
        ("", "Time;X;Y;Track ID", "seconds;micrometers;micrometers;", "1e0;{0};{1};A"),
    ],
)
def test_units_in_a_line_below_the_head_count(marks, above, head, units, columns, tmp_path):
    words = units.split(";")
    length = {"mm": 1e3, "cm": 1e2, "micrometers": 1e6}[words[1]]
    row = ";".join(f"{marks[0]}{word}{marks[1]}" if word.isalpha() else word for word in words)
    times = float(columns.partition(";")[0]) * TIMES
    cells = columns.partition(";")[2]
    body = [
        f"{t:.9g};{cells.format(*(f'{length * value:.9g}' for value in (*one, *other)))}".replace(".", ",")
        for t, one, other in zip(times, ONE, OTHER, strict=True)
    ]
    file = tmp_path / "tracks.csv"
    file.write_text(above + "\n".join([head, row, *body]))
    found = read_tracks(file)
    assert found.times == pytest.approx(TIMES)
    assert found.position[:, 0] == pytest.approx(ONE, abs=1e-9)


def test_text_instead_of_a_number_is_no_lost_spot(tmp_path):
    file = tmp_path / "tracks.csv"
    file.write_text(
        "t,x,y,id\n?,here,there,\n" + "".join(f"{t},{x},{y},1\n" for t, (x, y) in zip(TIMES, ONE, strict=True))
    )
    with pytest.raises(BadInput, match="line 2, time: got '\\?'"):
        read_tracks(file)


@pytest.mark.parametrize(("units", "what"), [("s,mm,,", "line 2, time: got 's'"), (",mm,,A", "line 2, x: got 'mm'")])
def test_a_unit_of_one_coordinate_is_no_lost_spot(units, what, tmp_path):
    """Such a line was taken as a spot that was not seen, and millimeters as meters."""
    file = tmp_path / "tracks.csv"
    rows = "".join(f"{t},{x},{y},1\n" for t, (x, y) in zip(TIMES, ONE, strict=True))
    file.write_text(f"t,x,y,id\n{units}\n0.5,,,1\n,nan,3.0,1\n{rows}")
    with pytest.raises(BadInput, match=what):
        read_tracks(file)
    file.write_text(f"t,x,y,id\n0.5,,,1\n,nan,3.0,1\n{rows}")
    assert read_tracks(file).names == ("1",)


@pytest.mark.parametrize("head", ["TRACK ID", "Track ID", "trackID", "track_id", "TrackID", "Particle ID"])
def test_names_of_columns_are_read_with_blanks_and_without(head, tmp_path):
    file = tmp_path / "tracks.csv"
    rows = [(t, *place, who) for who, path in ((1, ONE), (2, OTHER)) for t, place in zip(TIMES, path, strict=True)]
    file.write_text(f"t (s),x (m),y (m),{head}\n" + "".join(",".join(map(str, row)) + "\n" for row in rows))
    assert read_tracks(file).names == ("1", "2")
