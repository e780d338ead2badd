"""Reading TOML: the tables of a text, or the fault of its syntax with a hint. Excessive nesting is refused."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from ecume.errors import Fault

BARE = re.compile(r"[^=#]*=\s*([\w.+-][^\"'\[\]{}#=]*[^\W\d_][^\"'\[\]{}#=]*?)\s*(?:#.*)?$")
"""The pattern of a line with words without quotes."""


DEEPEST = 64
"""Tables in tables, and parts of a key."""

LONGEST_LINE = 400
"""The length of a line up to which a hint is searched."""


TOKENS = re.compile(
    r'''"""(?:\\.|[^\\])*?(?:"""|\Z)|\'{3}.*?(?:\'{3}|\Z)|"(?:\\.|[^"\\\n])*+"?|\'[^\'\n]*+\'?|\#[^\n]*|[=,{}\[\]\n.]''',
    re.DOTALL,
)
"""The pattern of separators of keys, and of texts and comments that may contain them."""


def tables_of(text: str) -> dict[str, Any]:
    """The tables of a TOML text. Raises ValueError, and RecursionError if it is nested too deeply."""
    require_shallow_keys(text)
    return _shallow(tomllib.loads(text))


def require_shallow_keys(text: str) -> None:
    """Raise RecursionError for a key with too many parts, `a.a.a ...`, for which Python's reader needs quadratic
    time.
    """
    parts = 0
    for token in TOKENS.finditer(text):
        mark = token[0]
        if mark == ".":
            parts += 1
            if parts > DEEPEST:
                raise RecursionError
        elif len(mark) == 1 and mark in "=,{}[]\n":
            parts = 0


def _shallow(raw: dict[str, Any]) -> dict[str, Any]:
    """The tables unchanged. Raises RecursionError if they are nested too deeply for later readers."""
    level: list[Any] = [raw]
    for _ in range(DEEPEST):
        level = [item for each in level for item in (each.values() if isinstance(each, dict) else each)]
        level = [item for item in level if isinstance(item, dict | list)]
        if not level:
            return raw
    raise RecursionError


BRACKETED = re.compile(r"\s*[A-Za-z_.]+\[[0-9]+\][A-Za-z0-9_.\[\]]*\s*=")
"""The pattern of a path with an index as a key."""


def syntax_fault(given: str, text: str) -> Fault:
    """The fault that corresponds to the message of Python's reader, with its position."""
    message, _, place = given.rpartition(" (at ")
    numbers = re.findall(r"\d+", place)
    ending = text.rstrip("\n").split("\n")
    line, column = map(int, numbers) if len(numbers) == 2 else (len(ending), len(ending[-1]) + 1)
    bare = BARE.match(ending[min(line, len(ending)) - 1][:LONGEST_LINE])
    word = bare[1].strip() if bare else ""
    switch = word.lower() if word.lower() in ("true", "false") else {"yes": "true", "no": "false"}.get(word.lower())
    hint = f'; text and numbers with units need quotes: "{word}"' if bare else ""
    hint = f"; write {switch}, in small letters" if switch else hint
    if "twice" in message:
        hint = "; expected each table once: put all its keys under one head"
    elif BRACKETED.match(ending[min(line, len(ending)) - 1][:LONGEST_LINE]):
        hint = '; a path with brackets needs quotes: "particles[0].count" = 30'
    return Fault("", f"is not TOML: {message or given}{hint}", line, column)
