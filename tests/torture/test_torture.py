"""A short form of the trials that are nowhere else in the tests; `sh scripts/torture` runs them whole."""

import os
import re

import pytest

from ecume.trajectories.frame import Frame
from tests.torture import __main__ as torture
from tests.torture.inputs import mutant, swapped
from tests.torture.regression import differing, recorded
from tests.torture.trials import Outcome, Trial

pytestmark = [
    pytest.mark.compiled,
    pytest.mark.skipif(os.name == "nt", reason="Windows forks no processes"),
    pytest.mark.filterwarnings("ignore"),
    pytest.mark.sampled(2),
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
    "R12 overlaps, floating": 0.1,
    "R12 overlaps, soft": 0.1,
    "R13 signals": 0.1,
    "R15 sweeps": 0.1,
    "R16 readers": 0.1,
    "R18 caches": 0.1,
    "R19 hostile titles": 0.3,
    "R19 strangers": 1.0,
    "R21 soak": 0.02,
}
"""Trials, and what part of them is tried here."""
TRIALS = {trial.name: trial for trial in torture.TRIALS}


LONG = {"R13 signals", "R15 sweeps", "R18 caches"}
"""Take seconds each."""


@pytest.mark.long
@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.long] * (name in LONG)) for name in BRIEFLY])
def test_everything_that_is_tried_is_survived(name, tmp_path):
    outcome = TRIALS[name].run(BRIEFLY[name], tmp_path)
    assert outcome.survived == outcome.tried > 0, outcome.note


def test_the_table_names_what_was_not_survived_and_the_rest_goes_on(tmp_path, capsys, monkeypatch):
    def breaks(scale, folder):
        raise ValueError("a defect")

    trials = (Trial("R1 bad", "a defect", breaks), Trial("R2 good", "nothing", lambda *_: Outcome(3, 3)))
    monkeypatch.setattr(torture, "TRIALS", trials)
    file = str(tmp_path / "table.md")
    assert torture.main(["--record", file]) == 1
    assert torture.main(["R2"]) == 0
    table = (tmp_path / "table.md").read_text()
    assert "| R1 bad | a defect | 1 | 0 **NOT** | ValueError: a defect |" in table
    assert "| R2 good | nothing | 3 | 3 |" in table
    assert re.match(r"20\d\d-\d\d-\d\d, scale 1, ecume", table)
    assert capsys.readouterr().out.count("**NOT**") == 1
    # Trials that are run one by one are put together; what was run at another scale is not.
    monkeypatch.setattr(torture, "TRIALS", (trials[0]._replace(run=lambda *_: Outcome(1, 1)), trials[1]))
    assert torture.main(["R1", "--record", file]) == 0
    assert [line.split(" | ")[3] for line in (tmp_path / "table.md").read_text().splitlines()[4:]] == ["1", "3"]
    with pytest.raises(SystemExit, match="of other circumstances"):
        torture.main(["R1", "--record", file, "--scale", "0.5"])


@pytest.mark.parametrize(
    ("words", "output"),
    [
        (["R99"], "no trial is called R99"),
        (["--scale", "0"], "argument --scale"),
        (["--scal"], "expected one argument"),
    ],
)
def test_what_is_no_trial_is_reported_in_a_line(words, output, capsys):
    with pytest.raises(SystemExit) as ended:
        torture.main(words)
    assert ended.value.code == 2
    assert output in capsys.readouterr().err


def test_help_lists_all_trials_with_what_they_do(capsys):
    with pytest.raises(SystemExit):
        torture.main(["--help"])
    output = capsys.readouterr().out
    assert all(f"{trial.name} " in output and trial.says in output for trial in torture.TRIALS)


def test_mutants_differ_from_what_they_were_made_of():
    import random

    chance, text = random.Random(1), b"duration = 1\nframe_every = 2\n" * 20
    assert sum(mutant(text, chance) != text for _ in range(100)) > 90
    assert swapped("radius") == "radisu"
    assert swapped("press") == "pressx"


def test_a_number_that_changes_is_found():
    (name, kept), *_ = ((name, one) for name, one in recorded().items() if one.frame == 200)
    frames = [Frame(0.0, {}, kept.numbers, {})] * (kept.frame + 1)
    assert differing(frames, kept, same=True) == differing(frames, kept, same=False) == {}
    key = kept.steady[0]
    frames[-1] = Frame(0.0, {}, {**kept.numbers, key: kept.numbers[key] * (1.0 + 1e-7)}, {})
    assert list(differing(frames, kept, same=True)) == [key]
    assert differing(frames, kept, same=False) == {}
    frames[-1] = Frame(0.0, {}, {}, {})
    assert set(differing(frames, kept, same=False)) == set(kept.steady), name
