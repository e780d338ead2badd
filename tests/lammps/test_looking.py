"""Runs integrated by LAMMPS can be plotted and viewed like others."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from ecume.cli import app
from ecume.run import RunOptions, run
from ecume_lammps.engine import lammps_engine
from tests.lammps.test_decks import DISH, scene_of
from tests.lammps.test_engine import in_lammps
from tests.lammps.test_tanks import tank

pytestmark = [in_lammps, pytest.mark.compiled, pytest.mark.sampled(2)]
SCENES = {
    "floats": lambda: scene_of(DISH).replace({"duration": 0.02, "frame_every": 0.01}),
    "tank": lambda: tank().replace({"duration": 0.01, "frame_every": 0.005}),
}


@pytest.fixture(scope="module", params=SCENES)
def home(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The directory of a short run."""
    home = tmp_path_factory.mktemp(request.param) / "run"
    with lammps_engine() as engine:
        run(SCENES[request.param](), home, options=RunOptions(engine=engine))
    return home


VERBS = {
    "info": [],
    "verify": [],
    "plot": ["--what", "energies"],
    "movie": ["--size", "160x120", "-o", "{}/run.gif"],
    "view": ["--save", "{}/run.html"],
    "export": ["--to", "vtk", "-o", "{}/run.vtkhdf"],
}


@pytest.mark.sampled(3)
@pytest.mark.parametrize("verb", VERBS)
def test_each_verb_accepts_the_run(verb: str, home: Path, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, [verb, str(home), *(word.format(tmp_path) for word in VERBS[verb])])
    assert done.exit_code == 0, done.output
    assert len(list(tmp_path.iterdir())) == sum("{}" in word for word in VERBS[verb])
