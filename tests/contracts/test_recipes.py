"""The recipes in docs/extend for a many-body method, an integrator, a measured quantity and a figure, run in a copy."""

import json
import re

import numpy as np
import pytest
from tests.contracts.recipes import Copy, block

# As plain Python in processes of their own, whatever this one does: once is enough.
pytestmark = [pytest.mark.compiled, pytest.mark.long]

INTERACTIONS = "models/floating/forces/interactions.py"
TIME_STEPS = "models/sph/integration/time_stepping.py"
INTEGRATORS = "models/floating/time_integration/integrators.py"
FIGURES = "show/floating/figures.py"
EDITS = {
    "many-body method": [(INTERACTIONS, name) for name in ("embedded-imports", "embedded", "embedded-row")],
    "integrator": [(TIME_STEPS, "semi-implicit"), (TIME_STEPS, "semi-implicit-row")],
    "integrator of floats": [(INTEGRATORS, "heun"), (INTEGRATORS, "heun-row")],
    "measured quantity": [
        ("models/floating/frames.py", name) for name in ("gyration-unit", "gyration-value", "gyration-cells")
    ],
    "figure": [(FIGURES, "fastest"), (FIGURES, "fastest-row"), ("show/figure_names.py", "fastest-name")],
}
"""By recipe: the file, and the code of the page, which goes where the text before it says."""

USE = """
import contextlib, io, json, sys
import numpy as np
from pathlib import Path
import ecume
from ecume.cli import main
from ecume.models.floating import FLOATING
from ecume.run import run
from ecume.models.floating.time_integration.integration import forces_at
from ecume.models.sph.record import SPH
from ecume.show.figures import figures_of
from ecume.show.floating import law_figures
from ecume.trajectories.frame import Frame

def end_of_blob(integrator, steps):
    scene = ecume.from_plain({
        "model": "sph", "duration": 0.02, "frame_every": 0.02, "spacing": 0.25, "gravity": [0.0, -1.0],
        "liquid": {"density": 1000.0, "sound_speed": 10.0},
        "tank": {"low": [-3.0, -3.0], "high": [3.0, 3.0]},
        "fluid": [{"low": [-0.5, -0.5], "high": [0.5, 0.5], "velocity_gradient": [[0.1, -0.5], [0.6, -0.3]]}],
        "method": {"initial_pressure": "zero"},
        "integration": {"integrator": integrator, "time_step": 0.02 / steps},
    })
    *_, last = ecume.simulate(scene)
    return last.arrays["position"]

exact = end_of_blob("symplectic", 32)
errors = [float(np.abs(end_of_blob("semi-implicit", steps) - exact).max()) for steps in (4, 8)]

def meeting(integrator, steps, **tables):
    scene = ecume.from_plain({
        "model": "floating", "duration": 0.08, "frame_every": 0.08,
        "particles": [{"radius": 1e-3, "density": 1300.0, "contact_angle": 1.5,
                       "positions": [[-1.3e-3, 0.0], [1.3e-3, 0.0]], "velocities": [[0.0, 0.01], [0.0, -0.01]]}],
        "integration": {"integrator": integrator, "time_step": 0.08 / steps}, **tables,
    })
    *_, last = ecume.simulate(scene)
    return last.arrays["position"]

wanted = meeting("rk4", 640)
heun = [float(np.abs(meeting("heun", steps) - wanted).max()) for steps in (40, 80)]
try:
    meeting("heun", 4, liquid={"viscosity": 1.0})
    refused = "nothing"
except ecume.SceneError as error:
    refused = str(error)
scene = ecume.from_plain({
    "model": "floating", "duration": 0.2, "frame_every": 0.1,
    "particles": [{"radius": 1e-3, "density": 1300.0, "contact_angle": 1.5, "positions": [[-3e-3, 0.0], [3e-3, 0.0]]}],
})
frames = list(ecume.simulate(scene))
in_cell = ecume.from_plain({
    "model": "floating", "duration": 0.1, "frame_every": 0.1, "cell": {"size": [0.08, 0.08]},
    "particles": [{"radius": 1e-3, "density": 1300.0, "contact_angle": 1.5,
                   "positions": [[1e-3, 0.04], [7.9e-2, 0.04]]}],
})
first_in_cell = next(ecume.simulate(in_cell))

def set_up(count, **tables):
    places = [[0.0, 0.0], [3.1e-3, 0.4e-3], [-0.5e-3, 3.2e-3], [4.2e-3, 3.9e-3]]
    scene = ecume.from_plain({
        "model": "floating", "duration": 0.2, "frame_every": 0.02,
        "particles": [{"radius": 1e-3, "density": 1300.0, "contact_angle": 1.5, "positions": places[:count]}],
        "interaction": {"method": "embedded"}, "hydrodynamics": {"drag": "none"}, **tables,
    })
    parameters = FLOATING.parameters(scene)
    state = FLOATING.start(scene, parameters)
    return scene, parameters, state, FLOATING.workspace(parameters, state, 1.0)

def forces_of(count):
    _, parameters, state, workspace = set_up(count)
    return forces_at(parameters, state.position, workspace).copy()

def potential(shift):
    _, parameters, state, workspace = set_up(4)
    forces_at(parameters, state.position, workspace)
    moved = state._replace(position=state.position + shift)
    return FLOATING.observe(parameters, moved, workspace).numbers["pair_energy"]

slope = np.zeros((4, 2))
for i, axis in np.ndindex(4, 2):
    shift = np.zeros((4, 2))
    shift[i, axis] = 1e-7
    slope[i, axis] = (potential(-shift) - potential(shift)) / 2e-7
embedded = {"forces": forces_of(4).tolist(), "slope": slope.tolist(), "two": forces_of(2).tolist(),
            "three": forces_of(3).tolist()}
for name, tables in {"smooth": {}, "rough": {"contacts": {"friction": 0.3}}}.items():
    rows = [frame.numbers for frame in ecume.simulate(set_up(4, **tables)[0])]
    embedded[name] = [[row["total_energy"], row["kinetic_energy"]] for row in rows]

def command(*words):
    sys.argv, said = ["ecume", *words], io.StringIO()
    with contextlib.redirect_stdout(said):
        try:
            main()
        except SystemExit as end:
            assert not end.code, (words, end.code)
    return said.getvalue()

run(scene, "met")
results = Path("met/results")
listed = "fastest" in command("plot", "met", "--list")
command("plot", "met", "--what", "fastest")
alone = [file.name for file in results.iterdir()]
(results / "fastest.png").unlink()
command("plot", "met")
axes = figures_of(scene)["fastest"](frames, scene).axes[0]
print(json.dumps({
    "errors": errors,
    "heun": heun,
    "compared": "heun" in law_figures.INTEGRATORS,
    "refused": refused,
    "embedded": embedded,
    "gyration": [frame.numbers["radius_of_gyration"] for frame in frames],
    "in_cell": sorted({"radius_of_gyration", "angular_momentum", "momentum_x"} & set(first_in_cell.numbers)),
    "unit": frames[0].units["radius_of_gyration"],
    "listed": listed,
    "alone": alone,
    "among_all": (results / "fastest.png").is_file(),
    "label": axes.get_ylabel(),
    "drawn": axes.lines[0].get_ydata().tolist(),
    "speeds": [frame.numbers["largest_speed"] for frame in frames],
}))
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The files that each recipe changed, and the output of a process with all of them."""
    copy, files = Copy(tmp_path_factory.mktemp("copy")), {}
    for recipe, edits in EDITS.items():
        copy.changed.clear()
        for file, name in edits:
            copy.follow(file, name)
        files[recipe] = {path.name for path in copy.changed}
    (report,) = copy.printed(USE, NUMBA_DISABLE_JIT="1")
    return files, json.loads(report)


@pytest.mark.long
@pytest.mark.parametrize("recipe", EDITS)
def test_a_recipe_changes_one_file_and_a_figure_its_name_in_another(made, recipe):
    assert len(made[0][recipe]) == (2 if recipe == "figure" else 1)


@pytest.mark.long
def test_a_new_method_has_forces_that_are_minus_the_slope_of_an_energy_of_many_bodies(made):
    found = {name: np.array(values) for name, values in made[1]["embedded"].items()}
    largest = np.abs(found["forces"]).max()
    assert found["forces"] == pytest.approx(found["slope"], abs=1e-5 * largest)
    assert np.abs(found["forces"].sum(axis=0)).max() < 1e-12 * largest
    third = found["three"][:2] - found["two"]
    assert abs(third[1] @ np.array([3.6, -2.8])) < 0.95 * np.hypot(*third[1]) * np.hypot(3.6, -2.8), "a sum over pairs"
    assert found["two"][0] @ (3.1, 0.4) < 0.0 < found["two"][1] @ (3.1, 0.4)


@pytest.mark.long
@pytest.mark.parametrize("contacts", ["smooth", "rough"])
def test_a_new_method_keeps_the_energy_with_any_contacts(made, contacts):
    total, kinetic = np.array(made[1]["embedded"][contacts]).T
    assert kinetic[-1] > 0.1 * total[0]
    assert total == pytest.approx(total[0], rel=1e-3)


@pytest.mark.long
def test_a_new_integrator_moves_a_tank_with_the_order_it_has(made):
    coarse, fine = made[1]["errors"]
    assert fine > 0.0
    assert coarse / fine == pytest.approx(2.0, rel=0.15)


@pytest.mark.long
def test_a_new_integrator_moves_floats_with_the_order_it_has(made):
    coarse, fine = made[1]["heun"]
    assert fine > 0.0
    assert coarse / fine == pytest.approx(4.0, rel=0.15)
    assert made[1]["compared"]
    assert "'heun' needs a time step below" in made[1]["refused"]


def test_a_new_quantity_is_in_frames_with_its_unit(made):
    first, *_, last = made[1]["gyration"]
    assert first == pytest.approx(3e-3)
    assert last < first
    assert made[1]["unit"] == "m"


def test_a_new_quantity_without_a_meaning_in_a_periodic_cell_is_not_in_its_frames(made):
    assert made[1]["in_cell"] == ["momentum_x"]


def test_a_new_figure_is_drawn_with_its_unit(made):
    assert re.fullmatch(r"largest speed \(.*m/s\)", made[1]["label"])
    assert len(made[1]["drawn"]) == len(made[1]["speeds"])
    assert made[1]["drawn"][-1] / made[1]["drawn"][1] == pytest.approx(made[1]["speeds"][-1] / made[1]["speeds"][1])


def test_a_new_figure_is_listed_and_drawn_by_the_command(made):
    assert made[1]["listed"]
    assert made[1]["alone"] == ["fastest.png"]
    assert made[1]["among_all"]


BEADS = """
import json
from pathlib import Path
from ecume.citing import papers_of
from ecume.cli.scenes import check
from ecume.errors import SceneError, Stopped
from ecume.models import MODELS
from ecume.run import RunOptions, resume, run
from ecume.scenes.load import load_scene
from ecume.show.figures import plot
from ecume.show.movies import MovieOptions, movie
from ecume.trajectories.reader import open_trajectory

def stop(progress):
    if progress.step > 700:
        raise Stopped("half way")

scene = load_scene('model = "beads"\\nduration = 2.0\\nframe_every = 0.1\\ncount = 5\\nseed = 3\\n')
run(scene, "whole")
try:
    run(scene, "halves", options=RunOptions(progress=stop, checkpoint_every=0.0))
except Stopped:
    resume("halves")
with open_trajectory("whole") as whole, open_trajectory("halves") as halves:
    same = [one.arrays["position"].tobytes() == other.arrays["position"].tobytes()
            for one, other in zip(whole, halves, strict=True)]
    energy = [frame.numbers["total_energy"] for frame in whole]
try:
    load_scene('model = "beds"\\nduration = 2.0\\nframe_every = 0.1\\n')
except SceneError as error:
    refused = str(error)
print(json.dumps({
    "same": same,
    "energy": energy,
    "papers": papers_of(scene),
    "movie": movie("whole", "ring.gif", MovieOptions(every=10, size=(240, 180))).stat().st_size,
    "figure": plot("whole", "energies").stat().st_size,
    "models": list(MODELS),
    "refused": refused,
}))
"""


@pytest.fixture(scope="module")
def ring(tmp_path_factory):
    """The output of a process that ran the model of the page, and the additional files of the package."""
    copy = Copy(tmp_path_factory.mktemp("beads"))
    copy.write("models/beads.py", block("beads"))
    copy.follow("models/__init__.py", "beads-row")
    (report,) = copy.printed(BEADS, NUMBA_DISABLE_JIT="1")
    return json.loads(report), {path.name for path in copy.changed}


@pytest.mark.long
def test_a_new_model_is_a_file_and_a_row(ring):
    report, changed = ring
    assert changed == {"__init__.py"}
    assert report["models"][-1] == "beads"
    assert '"beads"' in report["refused"]


@pytest.mark.long
def test_a_new_model_keeps_its_energy_and_resumes_bit_for_bit(ring):
    report, _ = ring
    assert report["energy"] == pytest.approx([report["energy"][0]] * 21, rel=1e-2)
    assert report["same"] == [True] * 21


@pytest.mark.long
def test_a_new_model_is_cited_and_drawn(ring):
    report, _ = ring
    assert report["papers"] == ["landau1987"]
    assert report["movie"] > 1000
    assert report["figure"] > 1000
