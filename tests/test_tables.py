"""Tables from which compiled code takes a row by the type of its constants."""

import dataclasses
from typing import NamedTuple

import pytest

from ecume._tables import by_constants
from ecume.laws import pair_laws
from ecume.models.floating.contacts import contact_models
from ecume.models.floating.forces import interactions
from ecume.models.floating.time_integration import integrators


class Row(NamedTuple):
    name: str
    constants: type
    force: object


def test_rows_of_one_type_may_differ_in_what_is_read_from_the_chosen_one():
    one, other, third = Row("a", int, max), Row("b", int, max), Row("c", float, min)
    assert by_constants([one, other, third], frozenset({"name"})) == {int: one, float: third}


def test_rows_of_one_type_with_different_functions_are_refused():
    rows = [Row("one", int, max), Row("other", int, min)]
    with pytest.raises(TypeError, match="one and other both have constants of the type int, but differ in force"):
        by_constants(rows, frozenset({"name"}))


@pytest.mark.parametrize(
    ("table", "function", "module"),
    [
        (integrators.INTEGRATORS, "predict", integrators),
        (interactions.INTERACTIONS, "add_forces", interactions),
        (interactions.RESISTANCES, "slow", interactions),
        (contact_models.CONTACTS, "before_drift", contact_models),
    ],
)
def test_a_row_of_a_model_with_another_s_constants_is_refused(table, function, module):
    first = next(iter(table.values()))
    second = dataclasses.replace(first, name="'mine'", **{function: print})
    with pytest.raises(TypeError, match=f"'mine' both have constants .* but differ in {function}"):
        by_constants([*table.values(), second], module.OF_THE_CHOICE)


def test_a_pair_law_with_another_s_constants_is_refused():
    capillary = pair_laws.PAIR_LAWS["capillary"]
    rows = [*pair_laws.PAIR_LAWS.values(), capillary._replace(force=pair_laws.one_sided_force)]
    with pytest.raises(TypeError, match="constants of the type Capillary, but differ in force"):
        by_constants(rows, pair_laws.OF_THE_CHOICE)
