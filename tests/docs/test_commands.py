"""Commands on pages name only scenes, tables and runs that are created earlier on the page."""

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "docs" / "start.md",
    ROOT / "docs" / "sweeps.md",
    *sorted((ROOT / "docs" / "how-to").glob("*.md")),
    *sorted((ROOT / "docs" / "tutorials").glob("*.md")),
]
BLOCK = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
NAMED = re.compile(r"`([\w./-]+\.(?:toml|csv|py|stl|dxf))`")
"""A file of the reader's own, which the text introduces."""
RUN_VERBS = {"movie", "plot", "view", "export", "resume", "info", "verify", "repair"}


def created(block: str) -> set[str]:
    """The name of the file that a block of a scene, a table or a program creates, from its first comment."""
    first = block.split("\n", 1)[0]
    return set(re.findall(r"[\w./-]+\.(?:toml|csv|py)", first)) if "#" in first else set()


def option(words: list[str], *names: str) -> str | None:
    """The value that follows an option."""
    return next((words[k + 1] for k, word in enumerate(words[:-1]) if word in names), None)


def followed(words: list[str], known: set[str]) -> list[str]:
    """The files that a command needs and that do not exist; the files that it creates are recorded."""
    verb, *rest = words
    plain = [word for word in rest if not word.startswith("-")]
    target = option(rest, "-o", "--out")
    needed = [word for word in plain if re.fullmatch(r"[\w./-]+\.(toml|csv)", word) and word != target]
    if verb in RUN_VERBS and plain and plain[0] not in (target, option(rest, "--what")):
        needed.append(plain[0])
    if verb == "new" and plain:
        known |= {target or f"{plain[0]}.toml"}
    if verb in ("run", "import", "sweep") and plain:
        known |= {target or f"{verb.replace('import', 'run')}s/{Path(plain[0]).stem}"}
    if verb == "export" and target:
        known |= {target}
    if verb == "fit" and target is None and plain:
        known |= {f"fits/{Path(plain[0]).stem}"}
    return [one for one in needed if one not in known]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_a_command_needs_nothing_that_was_not_created_above(page):
    text = page.read_text()
    known: set[str] = set()
    missing = []
    for block in BLOCK.finditer(text):
        known |= set(NAMED.findall(text[: block.start()]))
        if block[1] not in ("sh", "console", "bash"):
            known |= created(block[2])
            continue
        for line in block[2].splitlines():
            for command in line.split("&&"):
                words = shlex.split(command.removeprefix("$ "), comments=True)
                if words[:1] == ["ecume"] and len(words) > 1:
                    missing += [f"{line.strip()}: {one}" for one in followed(words[1:], known)]
    assert missing == []
