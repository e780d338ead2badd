"""The papers of a scene as BibTeX: those in the docstrings of its laws.

>>> from ecume.scenes.templates import folder
>>> from ecume.scenes.load import load_scene
>>> papers_of(load_scene((folder() / "two-spheres.toml").read_text()))[:2]
['nicolson1949', 'canbraun2022']
"""

from __future__ import annotations

import inspect
import re
import unicodedata
from collections.abc import Iterable
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from ecume._version import __version__
from ecume.models import MODELS

if TYPE_CHECKING:
    from ecume.scenes.schema import Scene

KEY = re.compile(r"\b[a-z]+\d{4}[a-z]?\b")


def papers_of(scene: Scene) -> list[str]:
    """The bibliography keys of the laws of a scene, in order of their use. Raises SceneError if the scene names an
    unknown law.
    """
    model = MODELS[scene.model]
    try:
        laws = model.laws(scene)
    except KeyError:
        model.parameters(scene)  # raises an error for an unknown name
        raise
    found = [key for law in laws for key in cited(inspect.getdoc(law) or "")]
    return [key for key in dict.fromkeys(found) if key in bibliography()]


def cited(text: str) -> list[str]:
    """The keys between brackets.

    >>> cited("Friction of a pair. [morris1997, eq. 22]")
    ['morris1997']
    """
    return [key for group in re.findall(r"\[([^\]]*)\]", text) for key in KEY.findall(group)]


def software() -> str:
    """The entry of ecume itself, with the present version."""
    fields = {
        "author": "{The ecume developers}",
        "title": "ecume: particles on, in and between liquids",
        "version": __version__,
        "note": "Python package",
        "license": "BSD-3-Clause",
    }
    lines = ",\n".join(f"  {name} = {{{value}}}" for name, value in fields.items())
    return f"@software{{ecume,\n{lines}\n}}"


def bibtex(keys: Iterable[str]) -> str:
    """The entry of ecume, followed by these entries of the bibliography."""
    return "\n\n".join([software(), *(bibliography()[key] for key in keys)]) + "\n"


def in_words(key: str) -> str:
    """An entry as a line: authors, year, title, where."""
    entry = bibliography()[key]
    found = {name: _field(entry, name) for name in ("author", "year", "title", "journal", "publisher", "doi")}
    where = found["journal"] or found["publisher"]
    address = f"doi:{found['doi']}" if found["doi"] else ""
    parts = (found["author"], found["year"] and f"({found['year']})", f"{found['title']}.", where, address)
    return " ".join(part for part in parts if part)


def _field(entry: str, name: str) -> str:
    match = re.search(rf"\b{name}\s*=\s*[{{\"](.*?)[}}\"],?\s*$", entry, re.MULTILINE | re.DOTALL)
    return without_latex(match[1]) if match else ""


ACCENTS = {'"': "\u0308", "'": "\u0301", "`": "\u0300", "^": "\u0302", "~": "\u0303", "c": "\u0327", "v": "\u030c"}
LETTERS = {r"\ss": "ß", r"\o": "ø", r"\O": "Ø", r"\l": "ł", r"\L": "Ł", r"\ae": "æ", r"\aa": "å", r"\i": "i"}


def without_latex(text: str) -> str:
    r"""Text of a bibliography without LaTeX: letters with accents, quotation marks, dashes.

    >>> without_latex(r"The ``{C}heerios effect'' of fluid--fluid films by M{\"o}bius")
    'The “Cheerios effect” of fluid–fluid films by Möbius'
    """
    for command, letter in LETTERS.items():
        text = re.sub(re.escape(command) + r"(?![A-Za-z])\s?", letter, text)
    accent = r"""\\(["'`^~]|[cv](?![A-Za-z]))\s*\{?([A-Za-z])\}?"""
    text = re.sub(accent, lambda found: unicodedata.normalize("NFC", found[2] + ACCENTS[found[1]]), text)
    for marks, sign in (("``", "“"), ("''", "”"), ("---", "—"), ("--", "–"), ("~", " ")):
        text = text.replace(marks, sign)
    return " ".join(re.sub(r"[{}$\\]", "", text).split())


@cache
def bibliography() -> dict[str, str]:
    """Every entry of the bibliography, by its key."""
    text = (files("ecume") / "references.bib").read_text(encoding="utf-8")
    return {match[1]: match[0].strip() for match in re.finditer(r"^@\w+\{(\w+),.*?^\}", text, re.MULTILINE | re.DOTALL)}
