"""A run with laws of the user's own goes on with just those laws, or not at all."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import toy

from ecume.errors import BadInput, StorageError
from ecume.run import Progress, RunOptions, resume, run, user_code

Scenes = Callable[..., toy.ToyScene]
STIFFNESS = 3.0


def springy(distance: float, parameters: Any) -> float:
    return STIFFNESS * halved(distance)


def halved(distance: float) -> float:
    return distance / 2.0


def slack(distance: float, parameters: Any) -> float:
    return 0.0


@pytest.fixture
def broken_off(tmp_path: Path, scene: Scenes) -> Path:
    """A run with a law of the user's own, that the disk refused in its middle."""

    def refuse(progress: Progress) -> None:
        if progress.step > 200:
            raise StorageError("no room")

    options = RunOptions(progress=refuse, checkpoint_every=0.0)
    with pytest.raises(StorageError, match="no room"):
        run(scene(), tmp_path / "run", extra_laws=[springy], options=options)
    return tmp_path / "run"


def test_the_manifest_names_the_laws_and_the_same_laws_go_on(broken_off: Path) -> None:
    (law,) = json.loads((broken_off / "manifest.json").read_text())["extra_laws"]
    assert (law["name"], len(law["sha256"])) == ("springy", 64)
    assert resume(broken_off, extra_laws=[springy]).frames == 51


@pytest.mark.parametrize(
    ("laws", "says"),
    [
        ([], r"started with the user-defined laws springy; .*\n?ecume resume .* --laws FILE\.py:springy\n"),
        ([slack], "got the laws slack; expected springy"),
        ([springy, slack], "got the laws springy, slack; expected springy"),
    ],
)
def test_other_laws_are_refused_and_the_run_stays_as_it_is(laws: Any, says: str, broken_off: Path) -> None:
    before = {path: path.read_bytes() for path in broken_off.rglob("*") if path.is_file() and path.name != "lock"}
    with pytest.raises(BadInput, match=says):
        resume(broken_off, extra_laws=laws)
    assert before == {path: path.read_bytes() for path in before}


def test_a_run_without_laws_of_the_users_own_takes_none_later(tmp_path: Path, scene: Scenes) -> None:
    run(scene(), tmp_path / "run")
    (tmp_path / "run" / "DONE.json").unlink()
    with pytest.raises(BadInput, match="got the laws springy; expected no user-defined laws"):
        resume(tmp_path / "run", extra_laws=[springy])


def test_a_law_whose_numbers_or_helpers_changed_is_another_law(
    broken_off: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in (("STIFFNESS", 3.5), ("halved", slack)):
        with monkeypatch.context() as changed:
            changed.setitem(globals(), name, value)
            with pytest.raises(BadInput, match="springy: the text of this law, or what it uses, has changed"):
                resume(broken_off, extra_laws=[springy])
    assert resume(broken_off, extra_laws=[springy]).frames == 51


def test_a_law_without_a_file_is_known_by_its_instructions() -> None:
    typed: dict[str, Any] = {}
    for name, text in (("one", "distance"), ("same", "distance"), ("other", "2 * distance")):
        exec(f"def law(distance, parameters): return {text}", typed)
        typed[name] = typed.pop("law")
    one, same, other = (user_code.entries([typed[name]])[0] for name in ("one", "same", "other"))
    assert one == same != other


FILE = """
import math

STIFFNESS = 2.0


def pull(distance, parameters):
    return -_halved(distance) * STIFFNESS


def push(distance, parameters):
    return math.exp(-distance)


def _halved(distance):
    return distance / 2.0


def with_one_argument(distance):
    return distance
"""


def test_a_file_gives_its_public_functions_of_two_or_four_arguments(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(FILE)
    assert [law.__name__ for law in user_code.laws_from([str(tmp_path / "mine.py")])] == ["pull", "push"]
    (one,) = user_code.laws_from([f"{tmp_path / 'mine.py'}:pull"])
    assert one(3.0, None) == -3.0


def test_a_file_of_the_same_text_gives_the_same_digest_wherever_it_is(tmp_path: Path) -> None:
    for name in ("one", "other"):
        (tmp_path / f"{name}.py").write_text(FILE)
    one, other = (user_code.entries(user_code.laws_from([str(tmp_path / f"{name}.py")])) for name in ("one", "other"))
    assert one == other
    (tmp_path / "other.py").write_text(FILE.replace("distance / 2.0", "distance / 2.5"))
    changed = user_code.entries(user_code.laws_from([str(tmp_path / "other.py")]))
    assert changed[0] != one[0]
    assert changed[1] == one[1]


@pytest.mark.parametrize(
    ("text", "word", "says"),
    [
        (FILE, "mine.txt", "expected FILE.py or FILE.py:NAME"),
        (FILE, "yours.py", "does not exist"),
        (FILE, "mine.py:pul", "has no function 'pul'; it has pull, push"),
        ("x = 1", "mine.py", "defines no function of two or four arguments"),
        ("def law(:", "mine.py", r"mine\.py, line 1: SyntaxError"),
        ("\n1 / 0", "mine.py", r"mine\.py, line 2: ZeroDivisionError"),
    ],
)
def test_a_file_that_gives_no_law_is_refused(text: str, word: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(text)
    with pytest.raises(BadInput, match=says):
        user_code.laws_from([str(tmp_path / word)])
