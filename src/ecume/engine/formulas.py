"""Formulas of the time, such as `0.05*sin(2*pi*t)`, with their exact first and second derivatives.

A formula is arithmetic on numbers, `t` and `pi`, with the functions in `FUNCTIONS`, `min` and `max`. It is parsed into
Python's syntax tree and evaluated here, so that it can neither name nor run anything else. Each part is evaluated
together with its derivatives (the chain rule to second order): where `abs`, `min` or `max` have a corner, the
derivatives are those of one of the branches.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from functools import cache

Jet = tuple[float, float, float]
"""A value, and its first and second derivatives."""
LONGEST = 300
"""The largest number of characters of a formula."""


def _outer(value: float, rate: float, second: float) -> Callable[[Jet], Jet]:
    """The rule f(u)' = f' u', f(u)'' = f'' u'^2 + f' u''."""
    return lambda u: (value, rate * u[1], second * u[1] * u[1] + rate * u[2])


def _tangent(x: float) -> tuple[float, float, float]:
    value = math.tan(x)
    return value, 1.0 + value * value, 2.0 * value * (1.0 + value * value)


def _hyperbolic_tangent(x: float) -> tuple[float, float, float]:
    value = math.tanh(x)
    return value, 1.0 - value * value, -2.0 * value * (1.0 - value * value)


FUNCTIONS: dict[str, Callable[[float], tuple[float, float, float]]] = {
    "sin": lambda x: (math.sin(x), math.cos(x), -math.sin(x)),
    "cos": lambda x: (math.cos(x), -math.sin(x), -math.cos(x)),
    "tan": _tangent,
    "exp": lambda x: (math.exp(x), math.exp(x), math.exp(x)),
    "log": lambda x: (math.log(x), 1.0 / x, -1.0 / (x * x)),
    "sqrt": lambda x: (math.sqrt(x), 0.5 / math.sqrt(x), -0.25 / (x * math.sqrt(x))),
    "sinh": lambda x: (math.sinh(x), math.cosh(x), math.sinh(x)),
    "cosh": lambda x: (math.cosh(x), math.sinh(x), math.cosh(x)),
    "tanh": _hyperbolic_tangent,
    "abs": lambda x: (abs(x), math.copysign(1.0, x), 0.0),
}
"""Functions of one number: the value, and its first and second derivatives."""
CHOICES: dict[str, Callable[..., Jet]] = {"min": min, "max": max}
"""Functions of several parts that choose one."""
KNOWN = "t, pi, + - * / **, " + ", ".join([*FUNCTIONS, *CHOICES])


def formula_fault(text: str) -> str:
    """What is wrong with a formula; empty if it can be evaluated.

    >>> formula_fault("0.1*sin(2*pi*t)")
    ''
    """
    if len(text) > LONGEST:
        return f"has {len(text)} characters; expected at most {LONGEST}"
    try:
        tree = _parsed(text)
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        return f"got {text!r}; expected a formula of the time t in s, such as 0.05*sin(2*pi*t)"
    return next((fault for node in ast.walk(tree) if (fault := _node_fault(node))), "") or _bare_function(tree)


def _bare_function(tree: ast.expr) -> str:
    """The fault of a function without its argument; empty without one."""
    called = {node.func for node in ast.walk(tree) if isinstance(node, ast.Call)}
    names = (node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and node not in called)
    bare = next((name for name in names if name not in {"t", "pi"}), "")
    return f"has the function {bare} without an argument; expected {bare}(...)" if bare else ""


@cache
def _parsed(text: str) -> ast.expr:
    return ast.parse(text.strip(), mode="eval").body


def _node_fault(node: ast.AST) -> str:
    """The fault of one part of a formula; empty without one."""
    match node:
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS and len(args) == 1:
            return ""
        case ast.Call(func=ast.Name(id=name), args=[_, _, *_], keywords=[]) if name in CHOICES:
            return ""
        case ast.Name(id=name) if name in {"t", "pi"} or name in FUNCTIONS or name in CHOICES:
            return ""
        case ast.Constant(value=value) if isinstance(value, (int, float)) and not isinstance(value, bool):
            return ""
        case ast.BinOp(op=ast.Pow(), right=power) if any(
            isinstance(x, ast.Name) and x.id == "t" for x in ast.walk(power)
        ):
            return "has t in an exponent; write exp(...) instead"
        case ast.BinOp() | ast.UnaryOp() | ast.Add() | ast.Sub() | ast.Mult() | ast.Div() | ast.Pow() | ast.Load():
            return ""
        case ast.USub() | ast.UAdd():
            return ""
    return f"got {_spelled(node)!r}; a formula knows {KNOWN}"


def _spelled(node: ast.AST) -> str:
    return ast.unparse(node) or type(node).__name__


def formula_at(text: str, time: float) -> Jet:
    """The value of a formula at a time, and its first and second derivatives. Raises ArithmeticError or ValueError
    where it has none.

    >>> formula_at("t**3 + 1", 2.0)
    (9.0, 12.0, 12.0)
    """
    return _jet(_parsed(text), time)


def _jet(node: ast.expr, time: float) -> Jet:
    match node:
        case ast.Constant(value=int() | float() as value):
            return float(value), 0.0, 0.0
        case ast.Name(id="t"):
            return time, 1.0, 0.0
        case ast.Name(id="pi"):
            return math.pi, 0.0, 0.0
        case ast.UnaryOp(op=ast.USub(), operand=inner):
            value, rate, second = _jet(inner, time)
            return -value, -rate, -second
        case ast.UnaryOp(operand=inner):
            return _jet(inner, time)
        case ast.BinOp(left=left, op=operator, right=right):
            return _joined(_jet(left, time), operator, _jet(right, time))
        case ast.Call(func=ast.Name(id=name), args=args) if name in CHOICES:
            return CHOICES[name](*(_jet(part, time) for part in args), key=lambda part: part[0])
        case ast.Call(func=ast.Name(id=name), args=[inner]):
            jet = _jet(inner, time)
            return _outer(*FUNCTIONS[name](jet[0]))(jet)
    raise ValueError(f"cannot evaluate {_spelled(node)!r}")


def _joined(a: Jet, operator: ast.operator, b: Jet) -> Jet:
    """The sum, difference, product, quotient or power of two parts."""
    match operator:
        case ast.Add():
            return a[0] + b[0], a[1] + b[1], a[2] + b[2]
        case ast.Sub():
            return a[0] - b[0], a[1] - b[1], a[2] - b[2]
        case ast.Mult():
            return a[0] * b[0], a[1] * b[0] + a[0] * b[1], a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2]
        case ast.Div():
            return _joined(a, ast.Mult(), _outer(1.0 / b[0], -1.0 / b[0] ** 2, 2.0 / b[0] ** 3)(b))
    return _power(a, b[0])


def _power(base: Jet, exponent: float) -> Jet:
    """The power of a part, with a constant exponent."""
    rate = exponent * base[0] ** (exponent - 1.0) if exponent != 0.0 else 0.0
    second = exponent * (exponent - 1.0) * base[0] ** (exponent - 2.0) if exponent not in (0.0, 1.0) else 0.0
    value = base[0] ** exponent
    if isinstance(value, complex):
        raise ValueError("a negative number has no such power")  # its value is at fault
    return _outer(value, rate, second)(base)
