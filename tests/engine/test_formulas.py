"""Formulas of the time: values, derivatives, and what they refuse."""

import math

import pytest

from ecume.engine.formulas import formula_at, formula_fault

FORMULAS = (
    "0.1*sin(2*pi*t)",
    "t**3 + 1",
    "exp(-t)*cos(3*t)/(1 + t**2)",
    "sqrt(1 + t)*tanh(t) - log(2 + t)",
    "abs(t - 2)**1.5",
    "min(t, 0.5)*2 + max(1, t**2)",
    "-tan(t/3) + sinh(t) - cosh(0.1*t)",
)


@pytest.mark.parametrize("text", FORMULAS)
def test_derivatives_are_those_of_the_value(text):
    assert formula_fault(text) == ""
    time, step = 0.7, 1e-4
    before, (value, rate, second), after = (formula_at(text, time + k * step) for k in (-1, 0, 1))
    assert rate == pytest.approx((after[0] - before[0]) / (2 * step), abs=1e-6)
    assert second == pytest.approx((after[1] - before[1]) / (2 * step), abs=1e-6)
    names = vars(math) | {"t": time, "abs": abs, "min": min, "max": max}
    assert value == eval(text, {"__builtins__": {}}, names)  # of the list above


@pytest.mark.parametrize(
    "text",
    ["__import__('os')", "t.real", "x + 1", "sin(t, t)", "2**t", "'a'", "t if t else 1", "[t]", "True", "1j", "t // 2",
     "", "(", "min(t)", "t < 1", "sin(x=t)", "(lambda: t)()", "+".join(["t"] * 200)],
)  # fmt: skip
def test_what_is_not_arithmetic_is_refused(text):
    assert formula_fault(text)


def test_values_that_do_not_exist_are_errors():
    for text in ("log(t - 1)", "1/t", "sqrt(-1 - t)", "(-1)**0.5", "9.0**9**9", "sin"):
        with pytest.raises((ArithmeticError, ValueError)):
            formula_at(text, 0.0)


def test_a_function_without_an_argument_is_named():
    assert formula_fault("t + sin(cos)") == "has the function cos without an argument; expected cos(...)"
