"""A short form of the trials that are nowhere else in the tests; `sh scripts/torture` runs them whole."""

import os
import re

import pytest

from tests.torture import __main__ as torture
from tests.torture.inputs import mutant, swapped
from tests.torture.trials import Outcome, Trial

pytestmark = [
    pytest.mark.compiled,
    pytest.mark.skipif(os.name == "nt", reason="Windows forks no processes"),
    pytest.mark.filterwarnings("ignore"),
]
BRIEFLY = {
    "R2 killed while writing": 0.03,
    "R8 mutated scenes": 0.02,
    "R9 generated scenes, floating": 0.02,
    "R9 generated scenes, soft": 0.02,
    "R9 generated scenes, sph": 0.02,
    "R9 generated scenes, tracers": 0.02,
    "R10 typos": 0.02,
    "R11 absurd scenes": 1.0,
    "R12 poisoned, floating": 0.1,
    "R12 poisoned, soft": 0.1,
    "R12 poisoned, tracers": 0.1,
}
"""Trials, and what part of them is tried here."""
TRIALS = {trial.name: trial for trial in torture.TRIALS}


@pytest.mark.parametrize("name", BRIEFLY)
def test_everything_that_is_tried_is_survived(name, tmp_path):
    outcome = TRIALS[name].run(BRIEFLY[name], tmp_path)
    assert outcome.survived == outcome.tried > 0, outcome.note


def test_the_table_names_what_was_not_survived_and_the_rest_goes_on(tmp_path, capsys, monkeypatch):
    def breaks(scale, folder):
        raise ValueError("a defect")

    trials = (Trial("R1 bad", "a defect", breaks), Trial("R2 good", "nothing", lambda *_: Outcome(3, 3)))
    monkeypatch.setattr(torture, "TRIALS", trials)
    assert torture.main(["--record", str(tmp_path / "table.md")]) == 1
    assert torture.main(["R2"]) == 0
    table = (tmp_path / "table.md").read_text()
    assert "| R1 bad | a defect | 1 | 0 **NOT** | ValueError: a defect |" in table
    assert "| R2 good | nothing | 3 | 3 |" in table
    assert re.match(r"20\d\d-\d\d-\d\d, ecume", table)
    assert capsys.readouterr().out.count("**NOT**") == 1


def test_mutants_differ_from_what_they_were_made_of():
    import random

    chance, text = random.Random(1), b"duration = 1\nframe_every = 2\n" * 20
    assert sum(mutant(text, chance) != text for _ in range(100)) > 90
    assert swapped("radius") == "radisu"
    assert swapped("press") == "pressx"
