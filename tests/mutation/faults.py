"""The small faults that a source file can be given: operators, constants, signs, bounds, and dropped terms and
statements.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import NamedTuple

OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "-",
    ast.Sub: "+",
    ast.Mult: "/",
    ast.Div: "*",
    ast.FloorDiv: "*",
    ast.Mod: "*",
    ast.Pow: "*",
    ast.BitAnd: "|",
    ast.BitOr: "&",
    ast.LShift: ">>",
    ast.RShift: "<<",
}
COMPARISONS: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Lt: ("<=", ">="),
    ast.LtE: ("<", ">"),
    ast.Gt: (">=", "<="),
    ast.GtE: (">", "<"),
    ast.Eq: ("!=", "!="),
    ast.NotEq: ("==", "=="),
}
"""What stands for each comparison: another bound, and the opposite."""
EXCHANGED = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "sin": "cos", "cos": "sin"}
IGNORED = (ast.Import, ast.ImportFrom, ast.Raise, ast.Assert, ast.JoinedStr)


class Fault(NamedTuple):
    """One change of a source file: the text between two offsets (in bytes) is replaced."""

    kind: str
    line: int
    begin: int
    end: int
    before: str
    after: str
    function: str
    """Where it stands: the names of the classes and functions around it."""


def faults(source: str) -> list[Fault]:
    """All faults of a file's text, in the order of their places."""
    found = list(_Search(source).of_body(ast.parse(source).body, ""))
    return sorted(found, key=lambda fault: (fault.begin, fault.end, fault.kind, fault.after))


def changed(source: str, fault: Fault) -> str:
    """The text with the fault. Raises ValueError if the text is not the one that the fault was found in."""
    data = source.encode()
    if data[fault.begin : fault.end].decode() != fault.before:
        raise ValueError(f"line {fault.line}: got {data[fault.begin : fault.end]!r}; expected {fault.before!r}")
    return (data[: fault.begin] + fault.after.encode() + data[fault.end :]).decode()


class _Search:
    def __init__(self, source: str) -> None:
        self._data = source.encode()
        self._lines = [0]
        for line in self._data.splitlines(keepends=True):
            self._lines.append(self._lines[-1] + len(line))

    def of_body(self, body: list[ast.stmt], function: str) -> Iterator[Fault]:
        """The faults of some statements."""
        for statement in body:
            if isinstance(statement, ast.FunctionDef | ast.ClassDef):
                inside = f"{function}.{statement.name}".lstrip(".")
                if isinstance(statement, ast.FunctionDef):
                    for default in [*statement.args.defaults, *filter(None, statement.args.kw_defaults)]:
                        yield from self._of_expression(default, inside)
                yield from self.of_body(statement.body, inside)
            elif not isinstance(statement, IGNORED) and not _is_for_types_only(statement):
                yield from self._of_statement(statement, function)

    def _of_statement(self, statement: ast.stmt, function: str) -> Iterator[Fault]:
        yield from self._dropped(statement, function)
        if isinstance(statement, ast.AugAssign) and type(statement.op) in OPERATORS:
            yield from self._operator(statement.op, statement.target, statement.value, function, "=")
        for name, value in ast.iter_fields(statement):
            if name in ("annotation", "type_comment") or (isinstance(statement, ast.For) and name == "target"):
                continue
            for part in value if isinstance(value, list) else [value]:
                if isinstance(part, ast.stmt):
                    yield from self.of_body([part], function)
                elif isinstance(part, ast.AST):
                    yield from self._of_expression(part, function)

    def _of_expression(self, node: ast.AST, function: str) -> Iterator[Fault]:
        if isinstance(node, IGNORED):
            return
        yield from self._here(node, function)
        for part in ast.iter_child_nodes(node):
            yield from self._of_expression(part, function)

    def _here(self, node: ast.AST, function: str) -> Iterator[Fault]:
        if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS and not _is_text(node):
            yield from self._operator(node.op, node.left, node.right, function)
            if not isinstance(node.op, ast.Pow):
                yield self._replaced("term dropped", node, self._text(node.left), function)
                if isinstance(node.op, ast.Add | ast.Mult):
                    yield self._replaced("term dropped", node, self._text(node.right), function)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
            kind = "sign" if isinstance(node.op, ast.USub) else "condition"
            yield self._replaced(kind, node, f"({self._text(node.operand)})", function)
        elif isinstance(node, ast.BoolOp):
            word = "or" if isinstance(node.op, ast.And) else "and"
            parts = [f"({self._text(value)})" for value in node.values]
            yield self._replaced("condition", node, f"({f' {word} '.join(parts)})", function)
        elif isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in COMPARISONS:
            for after in sorted(set(COMPARISONS[type(node.ops[0])])):
                yield from self._operator(node.ops[0], node.left, node.comparators[0], function, after=after)
        elif isinstance(node, ast.Constant):
            yield from self._constant(node, function)
        elif isinstance(node, ast.Call):
            name = node.func
            word = name.attr if isinstance(name, ast.Attribute) else name.id if isinstance(name, ast.Name) else ""
            if word in EXCHANGED:
                begin = self._place(name)[1] - len(word)
                yield self._fault("function", begin, begin + len(word), EXCHANGED[word], function)

    def _constant(self, node: ast.Constant, function: str) -> Iterator[Fault]:
        if isinstance(node.value, bool):
            yield self._replaced("constant", node, str(not node.value), function)
        elif isinstance(node.value, int):
            yield self._replaced("constant", node, str(node.value + 1), function)
        elif isinstance(node.value, float):
            yield self._replaced("constant", node, repr(2.0 * node.value) if node.value else "1.0", function)

    def _dropped(self, statement: ast.stmt, function: str) -> Iterator[Fault]:
        """A statement whose absence leaves every name defined."""
        is_call = isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Call)
        is_entry = isinstance(statement, ast.Assign) and all(isinstance(to, ast.Subscript) for to in statement.targets)
        if function and (is_call or is_entry or isinstance(statement, ast.AugAssign | ast.Continue | ast.Break)):
            yield self._replaced("statement dropped", statement, "pass", function)

    def _operator(
        self, op: ast.AST, left: ast.expr, right: ast.expr, function: str, suffix: str = "", after: str = ""
    ) -> Iterator[Fault]:
        begin, end = self._place(left)[1], self._place(right)[0]
        between = self._data[begin:end].decode()
        sign = _SIGNS[type(op)] + suffix
        where = between.find(sign)
        if between.replace(sign, "", 1).strip("() \n\t\\") == "" and where >= 0:
            kind = "comparison" if isinstance(op, ast.cmpop) else "operator"
            word = after or OPERATORS[type(op)] + suffix  # type: ignore[index]
            yield self._fault(kind, begin + where, begin + where + len(sign), word, function)

    def _place(self, node: ast.AST) -> tuple[int, int]:
        begin = self._lines[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
        return begin, self._lines[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]

    def _text(self, node: ast.AST) -> str:
        begin, end = self._place(node)
        return self._data[begin:end].decode()

    def _replaced(self, kind: str, node: ast.AST, after: str, function: str) -> Fault:
        return self._fault(kind, *self._place(node), after, function)

    def _fault(self, kind: str, begin: int, end: int, after: str, function: str) -> Fault:
        line = self._data.count(b"\n", 0, begin) + 1
        return Fault(kind, line, begin, end, self._data[begin:end].decode(), after, function)


_SIGNS: dict[type[ast.AST], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.FloorDiv: "//",
    ast.Mod: "%",
    ast.Pow: "**",
    ast.BitAnd: "&",
    ast.BitOr: "|",
    ast.LShift: "<<",
    ast.RShift: ">>",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
}


def _is_for_types_only(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.If) and "TYPE_CHECKING" in ast.dump(statement.test)


def _is_text(node: ast.BinOp) -> bool:
    """Whether an operator joins or formats text, or types."""
    parts = [part for side in (node.left, node.right) for part in ast.walk(side)]
    is_text = any(isinstance(part, ast.JoinedStr) or _is_string(part) for part in (node.left, node.right))
    return is_text or any(isinstance(part, ast.Constant) and part.value is None for part in parts)


def _is_string(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)
