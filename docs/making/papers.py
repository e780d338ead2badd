"""The page of the bibliography."""

from __future__ import annotations

from functools import cache

from writing import plain

from ecume.citing import bibliography, in_words


@cache
def known() -> frozenset[str]:
    """The keys of all papers."""
    return frozenset(bibliography())


def pages() -> dict[str, str]:
    """Each paper with its key, in the order of the keys."""
    rows = [f"({key})=\n`{key}`\n: {plain(in_words(key))}\n" for key in sorted(known())]
    head = "# Papers\n\nWhat the formulas rest on. `ecume cite SCENE` prints those of a scene as BibTeX.\n"
    return {"papers.md": "\n".join([head, *rows])}
