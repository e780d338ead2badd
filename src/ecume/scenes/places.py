"""The places of paths in a TOML file: line and column."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tree_sitter import Node

from ecume.scenes.faults import Path

Place = tuple[int, int]
"""Line and column, both from 1, in characters."""

KEYS = ("bare_key", "quoted_key", "dotted_key")
TABLES = ("table", "table_array_element")


def places(text: str) -> dict[Path, Place]:
    """The place of every table, key and list item of a TOML text that parses."""
    import tree_sitter
    import tree_sitter_toml

    language = tree_sitter.Language(tree_sitter_toml.language())
    root = tree_sitter.Parser(language).parse(text.encode()).root_node
    lines = text.encode().split(b"\n")
    return {
        path: (
            node.start_point[0] + 1,
            len(lines[node.start_point[0]][: node.start_point[1]].decode(errors="replace")) + 1,
        )
        for path, node in _entries(root)
    }


def place_of(path: Path, known: dict[Path, Place]) -> Place | tuple[None, None]:
    """The place of a path, or of the nearest piece around it; the file's beginning for a missing key.

    A list of tables as a whole is where its first one is.
    """
    if path not in known and (*path, 0) in known:
        return known[*path, 0]
    around = (known[path[:end]] for end in range(len(path), 0, -1) if path[:end] in known)
    return next(around, (1, 1) if path else (None, None))


def _entries(root: Node) -> Iterator[tuple[Path, Node]]:
    """Each path with the node that writes it."""
    counts: dict[Path, int] = {}
    for child in root.named_children:
        if child.type == "pair":
            yield from _values((), child)
        if child.type in TABLES:
            yield from _table(child, counts)


def _table(node: Node, counts: dict[Path, int]) -> Iterator[tuple[Path, Node]]:
    """A `[table]`, or one more `[[table]]` of a list: `counts` knows how many of each there were."""
    head: Path = ()
    names = _key(node.named_children[0])
    for depth, name in enumerate(names, 1):
        head += (name,)
        if node.type == "table_array_element" and depth == len(names):
            counts[head] = counts.get(head, 0) + 1
        if head in counts:
            head += (counts[head] - 1,)
    yield head, node
    for pair in node.named_children[1:]:
        if pair.type == "pair":
            yield from _values(head, pair)


def _values(head: Path, top: Node) -> Iterator[tuple[Path, Node]]:
    """A pair and all that its value holds. Without recursion: a file may nest as deep as it likes."""
    waiting = [(head, top)]
    while waiting:
        path, node = waiting.pop()
        if node.type == "pair":
            path, value = path + _key(node.named_children[0]), node.named_children[-1]
            yield path, node
        else:
            value = node
        if value.type == "inline_table":
            waiting += [(path, pair) for pair in value.named_children if pair.type == "pair"]
        if value.type == "array":
            items = [item for item in value.named_children if item.type != "comment"]
            yield from (((*path, index), item) for index, item in enumerate(items))
            waiting += [((*path, index), item) for index, item in enumerate(items)]


def _key(node: Node) -> Path:
    """The names of a key: two for `dish.radius`. Dotted keys nest, in the grammar, to the left."""
    if node.type == "dotted_key":
        return tuple(name for part in node.named_children if part.type in KEYS for name in _key(part))
    text = (node.text or b"").decode(errors="replace")
    if node.type == "quoted_key":
        text = str(tomllib.loads(f"key = {text}")["key"])
    return (text,)
