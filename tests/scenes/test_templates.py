"""The scenes that come with the package."""

from __future__ import annotations

import os
import re
import tomllib
from pathlib import Path

import pytest

from ecume.errors import BadInput, SceneError, StorageError
from ecume.scenes.load import load_scene
from ecume.scenes.templates import copy_template, templates


def typos(key: str) -> list[str]:
    """A letter lost, doubled, swapped, replaced."""
    middle = len(key) // 2
    return [
        key[:middle] + key[middle + 1 :],
        key[:middle] + key[middle] + key[middle:],
        key[: middle - 1] + key[middle] + key[middle - 1] + key[middle + 1 :],
        key[:-1] + "q",
    ]


def mistyped(text: str) -> list[tuple[str, str, str]]:
    """The text with one key mistyped, for each key and typo: (text, key, typo)."""
    keys = re.finditer(r"(?m)^(?:\[+)?([a-z_]{2,})(?= =|\]+$)", text)
    return [
        (text[: key.start(1)] + typo + text[key.end(1) :], key[1], typo)
        for key in keys
        for typo in typos(key[1])
        if typo != key[1]
    ]


@pytest.mark.parametrize("name", templates())
def test_a_template_copied_is_a_scene(name: str, tmp_path: Path) -> None:
    scene = load_scene(copy_template(name, tmp_path / "mine.toml")[0])
    assert scene.title
    assert scene.duration > scene.frame_every


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", templates())
def test_a_typo_in_any_key_of_a_template_is_refused_with_the_right_key(name: str, tmp_path: Path) -> None:
    file = copy_template(name, tmp_path / "mine.toml")[0]
    cases = mistyped(file.read_text())
    assert len(cases) > 20
    for text, key, typo in cases:
        file.write_text(text)
        with pytest.raises(SceneError) as caught:
            load_scene(file)
        output = str(caught.value)
        if key == "model":
            assert "model: is missing" in output
        else:
            assert f"{typo}: no such key; did you mean {key}?" in output


def test_the_first_line_of_a_template_says_what_it_shows() -> None:
    assert set(templates()) >= {"cereal-bowl", "original-2022", "two-spheres", "wall-climbing", "raft-from-table"}
    for says in templates().values():
        assert len(says) > 20
        assert says.endswith((".", ")"))


def test_the_cereal_bowl_holds_sixty_cereals(tmp_path: Path) -> None:
    raw = tomllib.loads(copy_template("cereal-bowl", tmp_path / "bowl.toml")[0].read_text())
    assert raw["particles"][0]["count"] == 60


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "raft-from-table.csv").write_text("mine")
    with pytest.raises(BadInput, match=r"raft-from-table\.csv exists already"):
        copy_template("raft-from-table", tmp_path / "scene.toml")
    assert not (tmp_path / "scene.toml").exists()
    assert (tmp_path / "raft-from-table.csv").read_text() == "mine"


@pytest.mark.skipif(os.name == "nt", reason="Windows knows no limit on the size of a file")
@pytest.mark.parametrize("room", [0, 20_000])  # the scene fits into the second, the field beside it does not
def test_a_full_disk_leaves_no_part_of_a_template(tmp_path: Path, room: int) -> None:
    import resource

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))
    try:
        with pytest.raises(StorageError, match="no room left"):
            copy_template("plankton-gyre", tmp_path / "new" / "scene.toml")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert not list((tmp_path / "new").iterdir())


def test_an_unknown_template_is_refused_with_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="did you mean cereal-bowl"):
        copy_template("cereal-bowls", tmp_path / "scene.toml")
    with pytest.raises(BadInput, match="`ecume new` lists them"):
        copy_template("../schema", tmp_path / "scene.toml")
