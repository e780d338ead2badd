"""Every pair of a model's options: merged into one scene, run for a few steps, and shown as a matrix in the docs."""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

from ecume.errors import SceneError
from ecume.models import MODELS
from ecume.models.invariants import NumberHistory, with_own
from ecume.scenes.schema import from_plain
from ecume.simulation import simulate

DOCS = Path(__file__).parents[2] / "docs" / "physics"


def merged(one, other):
    """Merge two plain trees; of a key that both set, the value of the second one. Lists of tables are merged table by
    table.
    """
    if isinstance(one, dict) and isinstance(other, dict):
        return {key: merged(one[key], other[key]) if {key} <= {*one} & {*other} else (one | other)[key]
                for key in {**one, **other}}  # fmt: skip
    if isinstance(one, list) and isinstance(other, list) and all(isinstance(part, dict) for part in one + other):
        pairs = itertools.zip_longest(one, other)
        return [b if a is None else a if b is None else merged(a, b) for a, b in pairs]
    return other


def clash(one, other):
    """The key at which two plain trees set different values, or an empty string."""
    if not (isinstance(one, dict) and isinstance(other, dict)):
        same_tables = isinstance(one, list) and one and isinstance(one[0], dict)
        found = next(filter(None, (clash(a, b) for a, b in zip(one, other, strict=False))), "") if same_tables else ""
        return found if same_tables or one == other else "."
    for key in one:
        if key in other and (where := clash(one[key], other[key])):
            return key if where == "." else f"{key}.{where}"
    return ""


def frames_of(plain, laws=()):
    """The frames of a scene, or the reason why it is refused; `laws` are passed if the scene names them."""
    try:
        return list(simulate(from_plain(plain), extra_laws=laws if "user_laws" in plain else ())), ""
    except SceneError as refused:
        return [], "; ".join(fault.message for fault in refused.faults)


def refusal(plain, laws=()):
    """The reason why a scene is refused, which is found before the first step; an empty string if it is not."""
    try:
        next(iter(simulate(from_plain(plain), extra_laws=laws if "user_laws" in plain else ())))
    except SceneError as refused:
        return "; ".join(fault.message for fault in refused.faults)
    return ""


def broken(plain, frames):
    """The faults that the invariants of the model find in these frames, as sentences."""
    scene = from_plain(plain)
    rows = MODELS[scene.model].invariants(scene, MODELS[scene.model].parameters(scene))
    lines = [with_own({**frame.numbers, "step": float(number)}) for number, frame in enumerate(frames)]
    least = {name: min(line[name] for line in lines if name in line) for name in lines[-1]}
    largest = {name: max(line[name] for line in lines if name in line) for name in lines[-1]}
    found = {row: row.value(NumberHistory(lines[0], lines[-1], least, largest)) for row in rows}
    return [f"{row.name}: {value:.3g}, limit {row.limit:.3g}" for row, value in found.items() if not value <= row.limit]


def require_sound(plain, frames):
    """Require that numbers are finite, particles have moved, and the invariants of the model hold."""
    for name in ("position", "velocity"):
        assert np.isfinite(frames[-1].arrays[name]).all(), name
    assert frames[-1].time > 0.0
    assert broken(plain, frames) == []


def matrix(options, refusals):
    """Markdown with a row and a column for each option, and the reasons for which pairs are refused."""
    names, letters = list(options), {}
    for reason in dict.fromkeys(refusals[pair] for pair in itertools.combinations(names, 2) if refusals.get(pair)):
        letters[reason] = chr(ord("a") + len(letters)) if len(letters) < 26 else f"a{chr(ord('a') + len(letters) - 26)}"
    head = "| | " + " | ".join(str(number) for number in range(1, len(names) + 1)) + " |"
    lines = [head, "|---|" + ":-:|" * len(names)]
    for number, one in enumerate(names, 1):
        cells = []
        for other in names:
            pair = (one, other) if (one, other) in refusals else (other, one)
            reason = refusals.get(pair)
            cells.append("" if one == other else "·" if reason == "" else "=" if reason is None else letters[reason])
        lines.append(f"| {number} {one} | " + " | ".join(cells) + " |")
    lines += ["", *(f"- {letter}: {reason}" for reason, letter in letters.items())]
    return "\n".join(lines)


MARKED = re.compile(r"(?<=<!-- option pairs -->\n).*?(?=\n<!-- end -->)", re.DOTALL)


def stated_in(options, text):
    """The entry of a matrix for each pair: None for two choices of one key, the reason of a refusal, or empty."""
    meanings = {"=": None, "·": ""} | dict(re.findall(r"^- (a?[a-z]): (.*)$", text, re.MULTILINE))
    rows = re.findall(r"^\| \d+ .*\|$", text, re.MULTILINE)
    return {
        (one, other): meanings.get(cell.strip(), cell)
        for number, (one, row) in enumerate(zip(options, rows, strict=False), 1)
        for other, cell in [*zip(options, row.split("|")[2:-1], strict=False)][number:]
    }


def section(page):
    """The generated part of a page, between its two markers."""
    return MARKED.search(page.read_text(encoding="utf-8"))[0]


def write_section(page, text):
    """Put a new matrix into a page."""
    page.write_text(MARKED.sub(lambda _: text, page.read_text(encoding="utf-8")), encoding="utf-8")


class Pairs:
    """The pairs of options of a model, their outcomes, and the page that shows them."""

    def __init__(self, page, options, plain_of, laws=()):
        self.page, self.options, self.plain_of, self.laws = DOCS / page, options, plain_of, laws
        self.names = list(itertools.combinations(options, 2))
        self._found = {}
        self.stated = stated_in(options, section(self.page))

    def outcome(self, one, other):
        """The frames, and the reason of a refusal; None if both options are choices of one key."""
        if (one, other) not in self._found:
            key = clash(self.options[one], self.options[other])
            self._found[one, other] = (None, key) if key else frames_of(self.plain_of(one, other), self.laws)
        return self._found[one, other]

    def require_works_or_reason(self, one, other):
        """A pair works, or the page states why not; a pair that sets one key twice is skipped."""
        frames, reason = self.outcome(one, other)
        found = None if frames is None else reason
        assert self.stated.get((one, other), "") == found, f"{self.page.name} says otherwise; it is written by its test"
        if frames is None:
            pytest.skip(f"both set {reason}")
        if not reason:
            require_sound(self.plain_of(one, other), frames)

    def reason(self, one, other):
        """The reason why a pair is refused, from earlier runs or from its start; None if both are choices of one
        key.
        """
        if (one, other) in self._found:
            frames, reason = self._found[one, other]
            return None if frames is None else reason
        if clash(self.options[one], self.options[other]):
            return None
        return refusal(self.plain_of(one, other), self.laws)

    def matrix(self):
        """The matrix that the page has to show."""
        return matrix(self.options, {pair: self.reason(*pair) for pair in self.names})
