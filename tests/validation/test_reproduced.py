"""Figures of papers, computed again."""

import csv
import subprocess
import sys

import pytest

from ecume.citing import bibliography
from ecume_validation.reproduced import REPRODUCED


def ecume(*arguments):
    command = [sys.executable, "-m", "ecume", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_every_figure_names_a_paper_of_the_bibliography():
    assert all(record.paper in bibliography() for record in REPRODUCED.values())


@pytest.mark.long
def test_the_list_names_every_figure():
    done = ecume("reproduce")
    assert all(name in done.stdout for name in REPRODUCED)


@pytest.mark.long
def test_an_unknown_figure_is_refused():
    done = ecume("reproduce", "t1-curse")
    assert done.returncode == 2
    assert "did you mean t1-course?" in done.stderr


@pytest.mark.long
@pytest.mark.compiled
@pytest.mark.parametrize("name", REPRODUCED)
def test_a_figure_comes_with_its_data_and_its_command(name, tmp_path):
    done = ecume("reproduce", name, "--quick", "-o", tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / f"{name}.png").stat().st_size > 5000
    text = (tmp_path / f"{name}.txt").read_text()
    assert f"command: ecume reproduce {name} --quick" in text
    assert f"{{{REPRODUCED[name].paper}," in text
    with (tmp_path / f"{name}.csv").open() as file:
        rows = list(csv.reader(file))
    assert len(rows) > 10
