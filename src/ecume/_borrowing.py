"""Compilation without reference counts for values that a function obtains from its arguments.

Numba increments a reference count for each array of a tuple when a variable is assigned the tuple or a field of it, and
decrements the count when the variable ends. Arguments here are tuples of up to a hundred arrays: most of the generated
code was such counting, and the compiler spent a third of its time on generating it and removing most of it again.

This counting is not necessary. A caller keeps its arguments alive during a call. Values that a function extracts from
its arguments, or combines only from these, therefore live at least as long as the function: they are *borrowed*. Values
that a function returns or stores, and values of other origin, are counted as before.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from typing import Any

from numba.core import ir, types
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import BaseNativeLowering, NativeLowering


def borrowed_variables(function: Any, kinds: Mapping[str, Any]) -> frozenset[str]:
    """The variables of a function, in Numba's representation, whose values the arguments keep alive; `kinds` are the
    types of variables.
    """
    sources: dict[str, list[list[str] | None]] = defaultdict(list)
    for block in function.blocks.values():
        for assignment in block.find_insts(ir.Assign):
            sources[assignment.target.name].append(_taken_from(assignment, kinds))
    borrowed = {
        name: [source for taken in definitions for source in taken or ()]
        for name, definitions in sources.items()
        if None not in definitions
    }
    while owned := [name for name, taken in borrowed.items() if any(source not in borrowed for source in taken)]:
        for name in owned:
            del borrowed[name]
    return frozenset(borrowed)


def _taken_from(assignment: Any, kinds: Mapping[str, Any]) -> list[str] | None:
    """The variables that must be borrowed so that the value of this assignment is borrowed as well; None if it never
    is.
    """
    value, kind = assignment.value, kinds[assignment.target.name]
    if isinstance(value, ir.Arg):
        return [] if kinds.get(f"arg.{value.name}") == kind else None
    if isinstance(value, ir.Var):
        return [value.name] if kinds[value.name] == kind else None
    if not isinstance(value, ir.Expr):
        return None
    if value.op == "null":
        return []
    if value.op in ("getattr", "static_getitem", "exhaust_iter"):
        return [value.value.name] if _is_taken_out(value, kinds[value.value.name]) else None
    if value.op == "build_tuple":
        return _put_together(value.items, kind, kinds)
    if (
        value.op == "call"
        and isinstance(kinds[value.func.name], types.NamedTupleClass)
        and not (value.kws or value.vararg)
    ):
        return _put_together(value.args, kind, kinds)
    return None


def _is_taken_out(expression: Any, kind: Any) -> bool:
    """Whether the expression is an item, a field or a part of a tuple of this type."""
    if not isinstance(kind, types.BaseTuple):
        return False
    return expression.op != "getattr" or expression.attr in getattr(kind, "fields", ())


def _put_together(items: Any, kind: Any, kinds: Mapping[str, Any]) -> list[str] | None:
    """The items of a new tuple; None if one of them is converted."""
    same = isinstance(kind, types.BaseTuple) and [kinds[item.name] for item in items] == list(kind)
    return [item.name for item in items] if same else None


class BorrowingLower(Lower):  # type: ignore[misc]  # Numba's types are skipped: they are incomplete
    """Code generation of a function in which only values that are not borrowed are reference-counted."""

    def init(self) -> None:
        """Find the borrowed values."""
        super().init()
        self.borrowed = borrowed_variables(self.func_ir, self.fndesc.typemap) if self.generator_info is None else ()
        self.counted: dict[Any, bool] = {}
        _ = self.context.nrt  # set while reference counting is enabled, since the value is cached

    def lower_inst(self, inst: Any) -> None:
        """Write the code of one statement."""
        name = inst.target.name if isinstance(inst, ir.Assign) else inst.value if isinstance(inst, ir.Del) else None
        if name not in self.borrowed:
            super().lower_inst(inst)
            return
        counting, self.context.enable_nrt = self.context.enable_nrt, False
        try:
            super().lower_inst(inst)
        finally:
            self.context.enable_nrt = counting

    def incref(self, typ: Any, val: Any) -> None:
        """Generate code that increments a reference count, for values with references."""
        if self.holds_references(typ):
            super().incref(typ, val)

    def decref(self, typ: Any, val: Any) -> None:
        """Generate code that decrements a reference count, for values with references."""
        if self.holds_references(typ):
            super().decref(typ, val)

    def holds_references(self, kind: Any) -> bool:
        """Whether values of this type contain arrays; cached, since Numba searches all fields of a tuple each time."""
        if kind not in self.counted:
            self.counted[kind] = self.context.data_model_manager[kind].contains_nrt_meminfo()
        return self.counted[kind]


@register_pass(mutates_CFG=True, analysis_only=False)
class BorrowingLowering(BaseNativeLowering):  # type: ignore[misc]
    """The compiler pass that uses this lowering."""

    _name = "borrowing_lowering"

    @property
    def lowering_class(self) -> type[Lower]:
        """The class that generates the code."""
        return BorrowingLower


def borrowing(steps: PassManager) -> PassManager:
    """The passes of a compilation, with Numba's lowering replaced by this one."""
    steps.passes = [(BorrowingLowering if step is NativeLowering else step, text) for step, text in steps.passes]
    steps.finalize()
    return steps
