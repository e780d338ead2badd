"""The sources of the pages of the site: written ones, and those that are made from the code."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

import commands
import functions
import gallery
import notebooks
import papers
import records

import scenes

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
SITE = "index.md"
"""Where links to the README lead: the site has a front page of its own."""
ELSEWHERE = {
    "README.md": SITE,
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "benchmarks/README.md": "benchmarks.md",
}
"""Pages beside the folder `docs`, and what they are called on the site."""
PICTURES = (".png", ".webp", ".svg")
DRAWN: tuple[Callable[[], dict[str, str]], ...] = (
    scenes.pages,
    functions.pages,
    commands.pages,
    papers.pages,
    gallery.pages,
    notebooks.pages,
)
"""Each gives pages by name."""
PARTS: dict[str, Callable[[], str]] = {
    "gallery": gallery.cards,
    "models": gallery.front,
    "validation": records.validation,
    "benchmarks": records.benchmarks,
}
"""What stands on a written page in place of `<!-- drawn: NAME -->`."""

CODE = re.compile(r"^```.*?^```[^\n]*$|`[^`\n]+`|^\$\$.*?\$\$|(?<!\$)\$[^$\n]+\$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
BRACKETS = re.compile(r"\[([^\[\]]+)\](?![(\[])")


def stage(folder: Path) -> None:
    """Lay all pages and pictures into a folder that is made anew."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for picture in DOCS.rglob("*"):
        if picture.suffix in PICTURES and picture.parent != gallery.CLIPS:
            place = folder / picture.relative_to(DOCS)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(picture, place)
    for name, text in (*written(folder), *((name, text) for draw in DRAWN for name, text in draw().items())):
        place = folder / name
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(_cited(text, PurePosixPath(name)) if place.suffix == ".md" else text, encoding="utf-8")


def written(folder: Path) -> Iterator[tuple[str, str]]:
    """The pages that people wrote, with links as the site wants them."""
    places = {page: page.relative_to(DOCS).as_posix() for page in sorted(DOCS.rglob("*.md"))}
    places |= {ROOT / page: name for page, name in ELSEWHERE.items()}
    for page, name in places.items():
        if name != SITE or page.parent == DOCS:
            yield name, _relinked(page, PurePosixPath(name), places, folder)


def _relinked(page: Path, name: PurePosixPath, places: dict[Path, str], folder: Path) -> str:
    """A page whose links lead to the site's pages; to a file that is none, to a copy of it."""

    def link(match: re.Match[str]) -> str:
        path, _, anchor = match[1].partition("#")
        if not path or re.match(r"[a-z]+:", path):
            return match[0]
        file = (page.parent / unquote(path)).resolve()
        if not file.is_relative_to(DOCS) and file not in places:
            target = f"files/{file.relative_to(ROOT).as_posix()}"
            (folder / target).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, folder / target)
        else:
            target = places.get(file) or file.relative_to(DOCS).as_posix()
        return f"]({os.path.relpath(target, name.parent)}{'#' if anchor else ''}{anchor})"

    linked = in_prose(page.read_text(encoding="utf-8"), lambda prose: LINK.sub(link, prose))
    return re.sub(r"<!-- drawn: (\w+) -->", lambda match: PARTS[match[1]](), linked)


def _cited(text: str, name: PurePosixPath) -> str:
    """A page where the keys of papers lead to the bibliography."""
    known = papers.known()
    if not known or name.name == "papers.md":
        return text
    there = os.path.relpath("papers.md", name.parent)

    def cite(match: re.Match[str]) -> str:
        keys = re.sub(
            r"\b[a-z]+\d{4}[a-z]?\b",
            lambda key: f"[{key[0]}]({there}#{key[0]})" if key[0] in known else key[0],
            match[1],
        )
        return match[0] if keys == match[1] else rf"\[{keys}\]"

    return in_prose(text, lambda prose: BRACKETS.sub(cite, prose))


def in_prose(text: str, change: Callable[[str], str]) -> str:
    """A page changed where it is neither code nor formula."""
    pieces, end = [], 0
    for code in CODE.finditer(text):
        pieces += [change(text[end : code.start()]), code[0]]
        end = code.end()
    return "".join([*pieces, change(text[end:])])
