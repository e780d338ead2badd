"""LAMMPS data files: a header with counts and the box, and the sections Masses, Atoms and Velocities."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ecume.trajectories.foreign.particles import (
    FileFault,
    Particles,
    box_of,
    edges_of,
    number,
    require_count,
    require_different,
    whole,
)

STYLES = {
    "atomic": "id type x y z",
    "charge": "id type q x y z",
    "dipole": "id type q x y z mux muy muz",
    "sphere": "id type diameter density x y z",
    "sph": "id type density esph cv x y z",
    "molecular": "id molecule type x y z",
    "bond": "id molecule type x y z",
    "angle": "id molecule type x y z",
    "full": "id molecule type q x y z",
}
"""The columns of each atom style; three image flags may follow."""
IMAGES = 3
SECTION = re.compile(r"[A-Z][A-Za-z]*(?: [A-Za-z]+){0,3}")
COUNT = re.compile(r"([0-9]+)\s+(atoms|atom types)")
SPAN = re.compile(r"(\S+)\s+(\S+)\s+([xyz])lo\s+\3hi")
EDGE = re.compile(r"(\S+)\s+(\S+)\s+(\S+)\s+([abc])vec")
"""An edge of a general triclinic box."""
TILT = re.compile(r"(\S+)\s+(\S+)\s+(\S+)\s+xy\s+xz\s+yz")


class Line(NamedTuple):
    """A line with its number, without its comment."""

    number: int
    words: list[str]


class Section(NamedTuple):
    """A section: its name, the style after `#`, and its lines."""

    line: int
    style: str
    lines: list[Line]


def read(text: str) -> Particles:
    """The particles of a data file. Raises FileFault, or ValueError without a line."""
    header, sections = _parts(text)
    counts, sides, tilt = _header(header)
    if "Atoms" not in sections:
        raise ValueError("has no section Atoms; expected a LAMMPS data file")
    atoms = sections["Atoms"]
    count = counts.get("atoms", (len(atoms.lines), atoms.line))
    if not atoms.lines:
        raise FileFault("got no atoms; expected one or more", atoms.line)
    require_count(count[0], len(atoms.lines), count[1])
    if count[0] != len(atoms.lines):
        raise FileFault(f"got {len(atoms.lines)} atoms; the header announces {count[0]}", atoms.line)
    columns = _style(atoms)
    values = {name: [] for name in columns}  # type: dict[str, list[float]]
    for line in atoms.lines:
        if len(line.words) not in (len(columns), len(columns) + IMAGES):
            expected = f"expected {len(columns)} ({' '.join(columns)}), or {IMAGES} image flags more"
            raise FileFault(f"got {len(line.words)} columns; {expected}", line.number)
        for name, word in zip(columns, line.words, strict=False):
            if name not in ("type", "molecule"):
                values[name].append(number(word, line.number))
    place = columns.index("type")
    labels = [line.words[place] for line in atoms.lines]
    names = _names(labels, sections)
    numbers = {name: number for number, name in enumerate(names)}
    kind = np.array([_kind(label, numbers, line.number) for label, line in zip(labels, atoms.lines, strict=True)])
    given = {name: np.array(values[name]) for name in ("diameter", "density") if name in columns}
    if "sphere" in atoms.style and not given["diameter"].all():
        raise FileFault("got a diameter of 0; expected spheres", atoms.line)
    require_different(values["id"], atoms.lines[0].number)
    order = {name: index for index, name in enumerate(map(int, values["id"]))}
    return Particles(
        names,
        kind.astype(np.int64),
        np.array([values[axis] for axis in "xyz"]).T,
        _velocities(sections, order),
        given.get("diameter"),
        _masses(sections, numbers, kind),
        given.get("density"),
        sides,
        tilt,
    )


def _parts(text: str) -> tuple[list[Line], dict[str, Section]]:
    """The lines of the header, and the sections; the first line is a title."""
    header: list[Line] = []
    sections: dict[str, Section] = {}
    into = header
    for line, style in _lines(text):
        name = " ".join(line.words)
        if SECTION.fullmatch(name) and (into is header or len(line.words) > 1 or line.words[0] in KNOWN):
            if name in sections:
                raise FileFault(f"got the section {name} for the second time", line.number)
            sections[name] = Section(line.number, style, [])
            into = sections[name].lines
        else:
            into.append(line)
    return header, sections


KNOWN = {"Atoms", "Velocities", "Masses", "Bonds", "Angles", "Dihedrals", "Impropers", "Ellipsoids", "Bodies", "Lines"}


def _lines(text: str) -> Iterator[tuple[Line, str]]:
    for place, line in enumerate(text.splitlines()[1:], 2):
        content, _, comment = line.partition("#")
        if words := content.split():
            yield Line(place, words), comment.strip()


def _header(lines: Sequence[Line]) -> tuple[dict[str, tuple[int, int]], tuple[float, float, float] | None, float]:
    """The counts with their lines, the sides of the box, and its largest tilt."""
    counts: dict[str, tuple[int, int]] = {}
    spans: dict[str, float] = {}
    edges: dict[str, list[float]] = {}
    tilt = 0.0
    for line in lines:
        text = " ".join(line.words)
        if match := COUNT.fullmatch(text):
            counts[match[2]] = whole(match[1], line.number), line.number
        elif match := SPAN.fullmatch(text):
            spans[match[3]] = number(match[2], line.number) - number(match[1], line.number)
        elif match := EDGE.fullmatch(text):
            edges[match[4]] = [number(match[part], line.number) for part in (1, 2, 3)]
        elif match := TILT.fullmatch(text):
            tilt = max(abs(number(match[part], line.number)) for part in (1, 2, 3))
    if len(edges) == 3:
        sides, tilt, _ = edges_of(np.array([edges[name] for name in "abc"]))
        spans = dict(zip("xyz", sides, strict=True))
    box = box_of([spans[axis] for axis in "xyz"]) if len(spans) == 3 else None
    return counts, box, tilt


def _style(atoms: Section) -> list[str]:
    """The columns of the section Atoms."""
    style = atoms.style.split()[0] if atoms.style else ""
    if not style and atoms.lines and len(atoms.lines[0].words) in (5, 5 + IMAGES):
        style = "atomic"
    if style not in STYLES:
        got = f"the atom style {style!r}" if style else "Atoms without its atom style"
        raise FileFault(f"got {got}; expected a line such as 'Atoms # sphere', with {', '.join(STYLES)}", atoms.line)
    return STYLES[style].split()


def _names(labels: Sequence[str], sections: Mapping[str, Section]) -> tuple[str, ...]:
    """The names of the types: their labels if the file has them, otherwise their numbers."""
    if "Atom Type Labels" in sections:
        lines = sections["Atom Type Labels"].lines  # labels may be in any order
        return tuple(line.words[-1] for line in sorted(lines, key=lambda line: whole(line.words[0], line.number, 1)))
    used = set(labels)
    return tuple(sorted(used, key=lambda label: (len(label), label)))


def _kind(label: str, names: Mapping[str, int], line: int) -> int:
    """The number of a type, given as a name or as a number from 1."""
    if label in names:
        return names[label]
    if label.isascii() and label.isdigit() and len(label) < 19 and 1 <= int(label) <= len(names):
        return int(label) - 1
    raise FileFault(f"got the type {label[:40]!r}; the file names {', '.join([*names][:20])[:200]}", line)


def _velocities(sections: Mapping[str, Section], order: Mapping[int, int]) -> np.ndarray | None:
    if "Velocities" not in sections:
        return None
    found = np.zeros((len(order), 3))
    for line in sections["Velocities"].lines:
        atom = int(number(line.words[0], line.number))
        if atom not in order or len(line.words) < 4:
            raise FileFault(f"got {' '.join(line.words)[:60]!r}; expected an atom's id and its velocity", line.number)
        found[order[atom]] = [number(word, line.number) for word in line.words[1:4]]
    return found


def _masses(sections: Mapping[str, Section], names: Mapping[str, int], kind: np.ndarray) -> np.ndarray | None:
    """The mass of each particle, by its type."""
    if "Masses" not in sections:
        return None
    masses = np.full(len(names), np.nan)
    for line in sections["Masses"].lines:
        if len(line.words) != 2:
            raise FileFault(f"got {len(line.words)} columns; expected a type and its mass", line.number)
        known = line.words[0] in names or (line.words[0].isdigit() and "Atom Type Labels" in sections)
        if known:
            masses[_kind(line.words[0], names, line.number)] = number(line.words[1], line.number)
    return masses[kind] if np.isfinite(masses[kind]).all() else None
