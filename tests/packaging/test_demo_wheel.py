"""`scripts/demo` installs wheels of compiled code: from `wheels/`, and the one that ECUME_COMPILED names."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

DEMO = Path(__file__).parents[2] / "scripts" / "demo"
WHEEL = "ecume_compiled-0.1.0-cp311-none-any.whl"


@pytest.fixture
def checkout(tmp_path):
    """A checkout with an environment, whose bowl has run and has a movie, so that only wheels are left to do."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", tmp_path / "env"], check=True)
    (tmp_path / "scripts").mkdir()
    shutil.copy(DEMO, tmp_path / "scripts")
    environment = 'say() { printf "%s\\n" "$@" >&2; }\nenvironment() { bin=$root/env/bin; }\n'
    (tmp_path / "scripts" / "environment.sh").write_text(environment)
    run = tmp_path / "runs" / "cereal-bowl"
    run.mkdir(parents=True)
    for path, when in ((run / "DONE.json", 1), (run / "movie.gif", 2), (tmp_path / "runs" / "cereal-bowl.toml", 1)):
        path.touch()
        os.utime(path, (when, when))
    return tmp_path


def make_wheel(path):
    path.parent.mkdir(exist_ok=True)
    with zipfile.ZipFile(path, "w") as wheel:
        wheel.writestr("ecume_compiled/MANIFEST.json", '{"files": {}}')


def installed(checkout, **environment):
    """The packages of the environment after the demo."""
    words = ["sh", "scripts/demo"]
    done = subprocess.run(
        words, cwd=checkout, env=os.environ | environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "has run already" in done.stderr
    return [path.name for path in checkout.glob("env/lib/python*/site-packages/*")]


@pytest.mark.skipif(os.name == "nt", reason="a shell script")
@pytest.mark.parametrize("named", [False, True])
def test_the_demo_installs_wheels_of_compiled_code(checkout, named):
    assert "ecume_compiled" not in installed(checkout)
    wheel = checkout / ("elsewhere" if named else "wheels") / WHEEL
    make_wheel(wheel)
    assert "ecume_compiled" in installed(checkout, **({"ECUME_COMPILED": str(wheel)} if named else {}))
