"""Trajectories of other programs as runs: positions and velocities are read, all else is computed."""

import numpy as np
import pytest

from ecume.errors import BadInput
from ecume.run import resume, verify
from ecume.run.imports import import_run
from ecume.scenes.load import load_scene
from ecume.simulation import simulate
from ecume.trajectories.reader import open_trajectory

BOWL = """\
model = "floating"
duration = "0.3 s"
frame_every = "20 ms"
seed = 3
[dish]
radius = "15 mm"
[liquid]
viscosity = "20 mPa*s"
"""
SPECIES = """\
[[particles]]
name = "{name}"
{count}
radius = "1.5 mm"
density = {density}
contact_angle = "80 deg"
"""
START = """\
[start_from]
file = "bowl.lammpstrj"
length_unit = "1 mm"
time_unit = "1 ms"
"""
ARRAYS, NUMBERS = (
    ("position", "velocity", "species", "radius"),
    ("pair_energy", "kinetic_energy", "contacts", "clusters"),
)


def species(count=""):
    """Two species; without a count they come from a file."""
    return "".join(
        SPECIES.format(name=name, density=density, count=count) for name, density in (("1", 600.0), ("2", 900.0))
    )


def dumped(frames, rng):
    """The frames as a dump in mm and ms, its rows in random order."""
    text = ""
    for step, frame in enumerate(frames):
        head = f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(frame.arrays['species'])}\n"
        text += head + "ITEM: BOX BOUNDS ff ff pp\n-20 20\n-20 20\n-1 1\nITEM: ATOMS id type x y vx vy\n"
        rows = zip(frame.arrays["species"], 1e3 * frame.arrays["position"], frame.arrays["velocity"], strict=True)
        lines = [
            f"{i} {kind + 1} {x:.17g} {y:.17g} {u:.17g} {v:.17g}\n" for i, (kind, (x, y), (u, v)) in enumerate(rows)
        ]
        text += "".join(lines[i] for i in rng.permutation(len(lines)))
    return text


@pytest.fixture(scope="module")
def bowl(tmp_path_factory):
    """A scene that names a dump, and the frames of which the dump was made."""
    folder = tmp_path_factory.mktemp("bowl")
    frames = list(simulate(load_scene(BOWL + species("count = 6"))))
    (folder / "bowl.lammpstrj").write_text(dumped(frames, np.random.default_rng(1)))
    (folder / "bowl.toml").write_text(BOWL + START + species())
    return folder / "bowl.toml", frames


def test_an_imported_run_has_the_frames_of_the_file_and_all_quantities(bowl, tmp_path):
    path, frames = bowl
    done = import_run(path, tmp_path / "run")
    assert done.frames == len(frames) == 16
    assert frames[-1].numbers["contacts"] > 0.0
    with open_trajectory(tmp_path / "run") as found:
        for one, other in zip(found, frames, strict=True):
            assert one.time == pytest.approx(other.time)
            for name in ARRAYS:
                assert one.arrays[name] == pytest.approx(other.arrays[name], rel=1e-9, abs=1e-12), name
            for name in NUMBERS:
                assert one.numbers[name] == pytest.approx(other.numbers[name], rel=1e-9), name


def test_an_imported_run_is_sound_but_cannot_be_computed_again(bowl, tmp_path):
    import_run(bowl[0], tmp_path / "run")
    assert verify(tmp_path / "run").sound
    with pytest.raises(BadInput, match=r"its frames were imported from bowl\.lammpstrj, not computed"):
        verify(tmp_path / "run", deep=True)
    (tmp_path / "run" / "DONE.json").unlink()
    with pytest.raises(BadInput, match="import the file again"):
        resume(tmp_path / "run")


@pytest.mark.parametrize(
    ("step", "old", "new", "message"),
    [
        (9, "ITEM: BOX", "ITEM: BAX", "without ITEM: BOX BOUNDS"),
        (7, "OF ATOMS\n12", "OF ATOMS\n11", "frame 7 has 11 particles; expected 12"),
        (3, "\n-20 20\n", "\n-20 nan\n", "line .*: got 'nan'"),
    ],
)
def test_a_frame_that_does_not_fit_is_named(bowl, tmp_path, step, old, new, message):
    path, _ = bowl
    (tmp_path / "bowl.toml").write_text(path.read_text())
    text = path.with_name("bowl.lammpstrj").read_text()
    before, mark, after = text.partition(f"ITEM: TIMESTEP\n{step}\n")
    assert old in after
    (tmp_path / "bowl.lammpstrj").write_text(before + mark + after.replace(old, new, 1))
    with pytest.raises(BadInput, match=message):
        import_run(tmp_path / "bowl.toml", tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_floats_that_overlap_in_a_later_frame_are_refused(bowl, tmp_path):
    path, frames = bowl
    (tmp_path / "bowl.toml").write_text(path.read_text())
    near = frames[5].arrays["position"].copy()
    near[1] = near[0] + 1e-3
    frames = [*frames[:5], frames[5]._replace(arrays={**frames[5].arrays, "position": near}), *frames[6:]]
    (tmp_path / "bowl.lammpstrj").write_text(dumped(frames, np.random.default_rng(1)))
    with pytest.raises(BadInput, match=r"bowl\.lammpstrj: frame 5: .*overlap"):
        import_run(tmp_path / "bowl.toml", tmp_path / "run")


def test_what_cannot_be_imported_is_refused(bowl, tmp_path):
    path, _ = bowl
    with pytest.raises(BadInput, match=r"no table \[start_from\]"):
        import_run(BOWL + species("count = 2"), tmp_path / "run")
    with pytest.raises(BadInput, match="length_unit"):
        import_run(path, tmp_path / "run", overrides=["start_from.length_unit=0"])
    with pytest.raises(BadInput, match="does not exist"):
        import_run(path, tmp_path / "run", overrides=["start_from.file=nothing.dump"])
    assert not (tmp_path / "run").exists()
