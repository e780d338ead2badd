"""Trajectories of other programs: dumps of LAMMPS and DCD files, read frame by frame."""

import struct

import numpy as np
import pytest

from ecume.trajectories.foreign import dcd, dumps, lammps, xyz
from ecume.trajectories.foreign.particles import MOST_PARTICLES, edges_of

PLACES = np.array(
    [[[1.0, 2.0, 0.0], [5.0, 2.0, 0.0], [9.5, -3.0, 0.0]], [[1.5, 1.75, 0], [5.5, 1.75, 0], [10, -3.25, 0]]]
)
"""(frames, particles, 3), in a box from (0, -5, -0.5) to (20, 5, 0.5)."""
LOW, SIDES = np.array([0.0, -5.0, -0.5]), np.array([20.0, 10.0, 1.0])
HEAD = "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp pp\n0 20\n-5 5\n-0.5 0.5\n"


def dump(columns, row):
    """A dump with the rows of each frame from the last particle to the first."""
    text = ""
    for step, places in enumerate(PLACES):
        rows = [row(number + 1, "121"[number], place) for number, place in enumerate(places)][::-1]
        text += HEAD.format(step=5 * step) + f"ITEM: ATOMS {columns}\n" + "".join(f"{one}\n" for one in rows)
    return text


def as_text(values):
    """Numbers with blanks between them."""
    return " ".join(f"{value:.17g}" for value in values)


ATOM = dump("id type xs ys zs", lambda number, kind, place: f"{number} {kind} {as_text((place - LOW) / SIDES)}")
CUSTOM = dump(
    "id element xu yu vx vy radius mass",
    lambda number, kind, place: f"{number} {'AB'[kind == '2']} {as_text(place[:2])} 0.5 -0.25 {number}.5 {number}",
)
YAML = "".join(
    f"""---
creator: LAMMPS
timestep: {step}
natoms: 3
boundary: [ p, p, p, p, p, p, ]
thermo:
  - keywords: [ Step, Temp, ]
  - data: [ 0, 2.5, ]
box:
  - [ 0, 20 ]
  - [ -5, 5 ]
  - [ -0.5, 0.5 ]
keywords: [ id, type, x, y, z, diameter,  ]
data:
"""
    + "".join(
        f"  - [ {number + 1} , {'121'[number]} , {x} , {y} , {z} , {number + 1}, ]\n"
        for number, (x, y, z) in enumerate(places)
    )
    + "...\n"
    for step, places in enumerate(PLACES)
)


def record(content):
    """A record of Fortran: its length, its content, its length."""
    return struct.pack("<i", len(content)) + content + struct.pack("<i", len(content))


def dcd_file(*, boxed=True, count=3):
    """A DCD file with the frames."""
    words = [0] * 20
    words[0], words[10] = len(PLACES), int(boxed)
    text = record(b"CORD" + struct.pack("<20i", *words)) + record(struct.pack("<i", 1) + b" " * 80)
    text += record(struct.pack("<i", count))
    for places in PLACES:
        text += record(struct.pack("<6d", 20.0, 90.0, 10.0, 90.0, 90.0, 1.0)) if boxed else b""
        text += b"".join(record(places[:, axis].astype("<f4").tobytes()) for axis in range(3))
    return text


@pytest.mark.parametrize("text", [ATOM, CUSTOM, YAML], ids=["atom", "custom", "yaml"])
@pytest.mark.parametrize("frame", [0, 1, -1])
def test_a_dump_holds_particles_in_the_order_of_their_ids(text, frame):
    found = dumps.read(text, frame)
    assert found.position == pytest.approx(PLACES[frame])
    assert found.kind.tolist() == [0, 1, 0]
    assert found.sides == tuple(SIDES)
    assert found.tilt == 0.0


def test_a_dump_holds_what_its_columns_name():
    custom, other = dumps.read(CUSTOM), dumps.read(YAML)
    assert custom.names == ("A", "B")
    assert custom.velocity.tolist() == [[0.5, -0.25, 0.0]] * 3
    assert custom.diameter.tolist() == [3.0, 5.0, 7.0]
    assert custom.mass.tolist() == [1.0, 2.0, 3.0]
    assert other.names == ("1", "2")
    assert other.diameter.tolist() == [1.0, 2.0, 3.0]
    assert other.velocity is other.mass is other.density is None


def test_a_tilted_box_is_reported():
    tilted = ATOM.replace("BOX BOUNDS pp", "BOX BOUNDS xy xz yz pp").replace("0 20\n", "0 20 -1.5\n")
    assert dumps.read(tilted).tilt == 1.5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "has no frame"),
        (
            ATOM.replace("NUMBER OF ATOMS\n3", "NUMBER OF ATOMS\n9"),
            "line 16: announces 9 particles",
        ),
        (ATOM.replace("NUMBER OF ATOMS\n3", f"NUMBER OF ATOMS\n{MOST_PARTICLES + 1}"), "at most"),
        (ATOM.replace("0 20", "0 inf"), "line 18: got 'inf'; expected a number"),
        (ATOM.replace("xs ys zs", "fx fy fz"), "expected x y z"),
        (ATOM.replace("ITEM: BOX", "ITEM: BAX"), "without ITEM: BOX BOUNDS"),
        (CUSTOM.replace(" -0.25 ", " "), "got 7 columns; expected 8"),
        (YAML.replace("natoms", "atoms"), "without natoms"),
        (YAML.replace("  - [ 0, 20 ]", "  - [ 0 ]"), "expected the low and the high end"),
    ],
)
def test_a_fault_of_a_dump_names_its_line(text, message):
    with pytest.raises(ValueError, match=message):
        dumps.read(text)


@pytest.mark.parametrize("boxed", [True, False])
def test_a_dcd_file_holds_positions_and_the_box(tmp_path, boxed):
    (tmp_path / "a.dcd").write_bytes(dcd_file(boxed=boxed))
    for frame in (0, 1, -1):
        found = dcd.read(tmp_path / "a.dcd", frame)
        assert found.position == pytest.approx(PLACES[frame], rel=1e-6)
    assert found.sides == (tuple(SIDES) if boxed else None)
    assert found.names == ("1",)
    with pytest.raises(ValueError, match="has no frame 2; there are 0 to 1"):
        dcd.read(tmp_path / "a.dcd", 2)


@pytest.mark.parametrize("seed", range(3))
def test_no_damage_of_a_file_is_a_traceback(tmp_path, seed):
    rng = np.random.default_rng(seed)
    refused = 0
    for original, read in ((dcd_file(), None), *((text.encode(), dumps) for text in (ATOM, CUSTOM, YAML))):
        for _ in range(60):
            data = bytearray(original)
            for place in rng.integers(0, len(data), rng.integers(1, 4)):
                data[place] = rng.integers(0, 256) if read is None else rng.integers(32, 127)
            data = data[: rng.integers(len(data) // 2, len(data) + 1)]
            try:
                if read is None:
                    (tmp_path / "a.dcd").write_bytes(data)
                    found = dcd.read(tmp_path / "a.dcd", 0)
                else:
                    found = read.read(data.decode())
                assert np.isfinite(found.position).all()
            except ValueError:
                refused += 1
    assert refused > 50


class Counted(str):
    """Text that counts how often it is divided."""

    divided = 0

    def splitlines(self, keepends=False):
        Counted.divided += 1
        return super().splitlines(keepends)


@pytest.mark.parametrize("text", [CUSTOM, ATOM, YAML])
def test_a_dump_is_divided_into_lines_once_and_each_frame_is_its_own(text):
    Counted.divided = 0
    count, frame = dumps.series(Counted(text))
    assert count == len(PLACES)
    for number in range(count):
        assert np.array_equal(frame(number).position, dumps.read(text, number).position)
    assert Counted.divided == 1


def test_a_frame_that_lacks_an_item_is_not_completed_by_the_next():
    broken = CUSTOM.replace("ITEM: BOX BOUNDS pp pp pp", "ITEM: SOMETHING", 1)
    count, frame = dumps.series(broken)
    with pytest.raises(ValueError, match="without ITEM: BOX BOUNDS"):
        frame(0)
    assert len(frame(count - 1).position) == 3


def test_momenta_are_velocities_times_masses():
    head = '1\nProperties=species:S:1:pos:R:3:momenta:R:3{} Lattice="9 0 0 0 9 0 0 0 9"\nAr 1 2 3 4 6 -8 '
    moving = xyz.series(head.format(":masses:R:1") + "2\n")[1](0)
    assert moving.velocity.tolist() == [[2.0, 3.0, -4.0]]
    with pytest.raises(ValueError, match="momenta without masses"):
        xyz.series(head.format("") + "\n")[1](0)


TILTED = """\
ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS xy xz yz pp pp pp
-3 15 5
0 12 -3
-1 7 2
ITEM: ATOMS id type xs ys zs
1 1 0 0 0
2 1 0.25 0.5 0.75
"""


def test_scaled_positions_in_a_tilted_box_are_those_of_its_edges():
    """The bounds of LAMMPS contain the tilts: here the box begins at (0, 0, -1), with the edges (10, 0, 0), (5, 10, 0)
    and (-3, 2, 8).
    """
    found = dumps.read(TILTED)
    assert found.position == pytest.approx(np.array([[0, 0, -1], [2.5 + 2.5 - 2.25, 5 + 1.5, 5]]))
    assert (found.sides, found.tilt) == ((10.0, 10.0, 8.0), 5.0)


def test_unwrapped_positions_are_read_where_wrapped_ones_have_no_image_numbers():
    both = dump("id type x y xu yu", lambda number, kind, place: f"{number} {kind} 1 2 {as_text(place[:2] + 40)}")
    found = dumps.read(both)
    assert found.position[:, :2] == pytest.approx(PLACES[-1, :, :2] + 40)
    assert not found.image.any()


def test_extended_xyz_is_sorted_by_its_ids():
    text = "2\nProperties=species:S:1:pos:R:3:id:I:1 Time=0.5\nA 1 2 0 7\nB 3 4 0 2\n"
    found = xyz.read(text)
    assert found.position.tolist() == [[3, 4, 0], [1, 2, 0]]
    assert [found.names[kind] for kind in found.kind] == ["B", "A"]
    assert found.instant == 0.5


def test_a_box_of_edges_and_an_origin_is_that_of_its_bounds():
    """`dump_modify triclinic/general` writes edges a, b, c with the origin behind them."""
    rows = "ITEM: ATOMS id xs ys zs\n1 0.25 0.5 0.5\n"
    head = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\n"
    bounds = dumps.read(f"{head}ITEM: BOX BOUNDS pp pp pp\n0 20\n-5 5\n-0.5 0.5\n{rows}")
    edges = dumps.read(f"{head}ITEM: BOX BOUNDS abc origin pp pp pp\n20 0 0 0\n0 10 0 -5\n0 0 1 -0.5\n{rows}")
    assert edges.position.tolist() == bounds.position.tolist() == [[5.0, 0.0, 0.0]]
    assert edges.sides == bounds.sides == (20.0, 10.0, 1.0)
    tilted = dumps.read(f"{head}ITEM: BOX BOUNDS abc origin pp pp pp\n20 0 0 0\n3 10 0 -5\n0 0 1 -0.5\n{rows}")
    assert tilted.position.tolist() == [[6.5, 0.0, 0.0]]
    assert tilted.tilt == 3.0
    with pytest.raises(ValueError, match="got 2 numbers; expected an edge of the box"):
        dumps.read(f"{head}ITEM: BOX BOUNDS abc origin pp pp pp\n0 20\n-5 5\n-0.5 0.5\n{rows}")


def test_every_format_tells_the_tilt_of_its_box():
    """The box with the edges (20, 0, 0), (1.5, 10, 0) and (0, 0, 1), as each program writes it."""
    atoms = "\nAtoms # atomic\n\n1 2 1 2 0\n2 1 5 2 0\n"
    edges = "20 0 0 avec\n1.5 10 0 bvec\n0 0 1 cvec\n0 -5 -0.5 abc origin\n"
    sides = "0 20 xlo xhi\n-5 5 ylo yhi\n-0.5 0.5 zlo zhi\n1.5 0 0 xy xz yz\n"
    comment = 'Lattice="20 0 0 1.5 10 0 0 0 1" pbc="{}"'
    found = [
        dumps.read(YAML.replace("[ 0, 20 ]", "[ 0, 21.5 ]").replace("0.5 ]\nk", "0.5 ]\n  - [ 1.5, 0, 0 ]\nk")),
        lammps.read(f"title\n2 atoms\n{sides}{atoms}"),
        lammps.read(f"title\n2 atoms\n{edges}{atoms}"),
        *(xyz.read(f"1\n{comment.format(periodic)}\nA 1 2 0\n") for periodic in ("T T F", "1 1 0", "[True, True]")),
    ]
    assert [(one.sides, one.tilt) for one in found] == [((20.0, 10.0, 1.0), 1.5)] * len(found)
    single = comment.replace('"', "'").format("T T F")
    assert xyz.read(f"1\n{single}\nA 1 2 0\n").sides == (20.0, 10.0, 1.0)
    assert xyz.read(f"1\n{comment.format('0 0 0')}\nA 1 2 0\n").sides is None


def test_labels_of_types_are_read_in_any_order():
    labels = "title\n2 atoms\n2 atom types\n\nAtom Type Labels\n\n2 small\n1 large\n\nAtoms # atomic\n\n"
    found = lammps.read(labels + "1 2 1 2 0\n2 large 5 2 0\n")
    assert [found.names[kind] for kind in found.kind] == ["small", "large"]


@pytest.mark.parametrize(
    ("angles", "tilted"), [((90.0, 90.0, 90.0), False), ((6e-17, 0.0, 90.00001), False), ((0.5, 0.0, 0.0), True)]
)
def test_angles_of_a_dcd_box_are_upright_within_rounding(tmp_path, angles, tilted):
    usual, other = (struct.pack("<6d", 20.0, a, 10.0, b, c, 1.0) for a, b, c in ((90.0, 90.0, 90.0), angles))
    (tmp_path / "box.dcd").write_bytes(dcd_file().replace(usual, other))
    assert bool(dcd.read(tmp_path / "box.dcd").tilt) == tilted


TURNED = [[0, 20, 0], [-10, 0, 0], [0, 0, 1]]
"""The edges of a box of 10 x 20 x 1, turned by 90 degrees: the first image of each edge is one up and one back."""
FROM_IMAGES = np.array([[2, 1, 0], [-1, 2, 0]])


@pytest.mark.parametrize("third", [[0, 0, 1], [0, 0, 0]])
def test_edges_turned_by_right_angles_are_a_rectangular_box(third):
    edges = [*TURNED[:2], third]
    found = edges_of(np.array(edges, float))
    assert (found.sides, found.tilt) == ((10.0, 20.0, float(third[2])), 0.0)
    images = np.array([[1, -2, 0], [2, 1, 0]])
    assert (images @ found.images == FROM_IMAGES).all()
    text = " ".join(str(value) for edge in edges for value in edge)
    comment = f'Lattice="{text}" Properties=species:S:1:pos:R:3:image:I:3'
    of_xyz = xyz.read(f"2\n{comment}\nA 1 2 0 1 -2 0\nA 3 4 0 2 1 0\n")
    assert (of_xyz.sides, of_xyz.tilt) == (found.sides, 0.0)
    assert (of_xyz.image == FROM_IMAGES).all()
    data = "".join(f"{' '.join(map(str, edge))} {name}vec\n" for edge, name in zip(edges, "abc", strict=True))
    of_data = lammps.read(f"title\n\n2 atoms\n{data}0 0 0 abc origin\n\nAtoms # atomic\n\n1 1 1 2 0\n2 1 3 4 0\n")
    assert (of_data.sides, of_data.tilt) == (found.sides, 0.0)
    bounds = "".join(f"{' '.join(map(str, edge))} 0\n" for edge in edges)
    head = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS abc origin pp pp pp\n"
    of_dump = dumps.read(f"{head}{bounds}ITEM: ATOMS id x y z ix iy iz\n1 1 2 0 1 -2 0\n2 3 4 0 2 1 0\n")
    assert (of_dump.sides, of_dump.tilt) == (found.sides, 0.0)
    assert (of_dump.image == FROM_IMAGES).all()


def test_edges_turned_by_other_angles_are_a_tilted_box():
    assert edges_of(np.array([[8.0, 6.0, 0.0], [-6.0, 8.0, 0.0], [0.0, 0.0, 1.0]])).tilt == pytest.approx(6.0)
