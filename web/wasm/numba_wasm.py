"""Compiles functions that Numba compiles for the processor to WebAssembly: the same laws, a second target.

Numba's text is taken before it is optimized for the processor at hand. In it, globals of linkage `common`, which
WebAssembly does not have, get another one; counting of references, which Numba writes as atomic operations of x86-64,
gets the functions in `RUNTIME`; what only Python or threads could do ends the module. A fused product and sum is
rounded twice, as it is in plain Python: WebAssembly has no instruction for it whose bits are the same in all browsers.

An entry takes the address of a block: eight slots of eight bytes for the result, and one for each number that Numba
makes of the arguments: see `ecume.show.play.memory`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

import llvmlite.binding as llvm

from ecume._parts import libraries_are_parts

FEATURES = "+simd128,+bulk-memory,+sign-ext,+nontrapping-fptoint,+mutable-globals"
"""What all browsers have had since 2021."""
PROVIDED = {
    "exp", "log", "pow", "sin", "cos", "sqrt", "atan2", "expm1", "log1p", "tanh", "fmod", "floor", "ceil", "trunc",
    "memcpy", "memset", "memmove",
}  # fmt: skip
"""Undefined names that the linker finds in the libraries; those of Python and of Numba's runtime end the module."""
OF_C = re.compile(r"[a-z][a-z0-9]*")
"""Names of C's libraries, which must be provided: a law calls them."""

RUNTIME = """
@here = global i32 0
@start = global i32 0

define double @rounded_twice(double %a, double %b, double %c) alwaysinline {
  %product = fmul double %a, %b
  %sum = fadd double %product, %c
  ret double %sum
}

define void @memory_from(i32 %address) {
  store i32 %address, ptr @start
  store i32 %address, ptr @here
  ret void
}

define void @NRT_incref(ptr %block) {
  %none = icmp eq ptr %block, null
  br i1 %none, label %end, label %count
count:
  %old = load i64, ptr %block
  %new = add i64 %old, 1
  store i64 %new, ptr %block
  br label %end
end:
  ret void
}

define void @NRT_decref(ptr %block) {
  %none = icmp eq ptr %block, null
  br i1 %none, label %end, label %count
count:
  %old = load i64, ptr %block
  %new = sub i64 %old, 1
  store i64 %new, ptr %block
  %unused = icmp eq i64 %new, 0
  br i1 %unused, label %free, label %end
free:
  %next = getelementptr i8, ptr %block, i32 8
  %after = load i32, ptr %next
  %top = load i32, ptr @here
  %last = icmp eq i32 %after, %top
  br i1 %last, label %back, label %end
back:
  %address = ptrtoint ptr %block to i32
  store i32 %address, ptr @here
  br label %end
end:
  ret void
}

define ptr @NRT_MemInfo_data_fast(ptr %block) {
  %data = getelementptr i8, ptr %block, i32 64
  ret ptr %data
}

define ptr @NRT_MemInfo_alloc_aligned(i64 %size, i32 %align) {
  %bytes = trunc i64 %size to i32
  %at = load i32, ptr @here
  %more = add i32 %bytes, 127
  %whole = and i32 %more, -64
  %after = add i32 %at, %whole
  %pages = call i32 @llvm.wasm.memory.size.i32(i32 0)
  %end = shl i32 %pages, 16
  %fits = icmp ule i32 %after, %end
  br i1 %fits, label %give, label %grow
grow:
  %lacking = sub i32 %after, %end
  %up = lshr i32 %lacking, 16
  %pages_more = add i32 %up, 1
  %grown = call i32 @llvm.wasm.memory.grow.i32(i32 0, i32 %pages_more)
  %full = icmp eq i32 %grown, -1
  br i1 %full, label %trap, label %give
trap:
  call void @llvm.trap()
  unreachable
give:
  store i32 %after, ptr @here
  %block = inttoptr i32 %at to ptr
  store i64 1, ptr %block
  %next = getelementptr i8, ptr %block, i32 8
  store i32 %after, ptr %next
  %data = getelementptr i8, ptr %block, i32 64
  %pointer = getelementptr i8, ptr %block, i32 24
  store ptr %data, ptr %pointer
  ret ptr %block
}

define i32 @numba_attempt_nocopy_reshape(i64 %nd, ptr %n, ptr %s, i64 %axes,
                                         ptr %sizes, ptr %strides, i64 %item, i32 %f) {
  %row = icmp eq i64 %axes, 1
  br i1 %row, label %one, label %more
one:
  store i64 %item, ptr %strides
  ret i32 1
more:
  %old = load i64, ptr %s
  %next = icmp eq i64 %old, %item
  %from = icmp eq i64 %nd, 1
  %to = icmp eq i64 %axes, 2
  %both = and i1 %from, %to
  %well = and i1 %both, %next
  br i1 %well, label %two, label %trap
two:
  %second = getelementptr i64, ptr %sizes, i32 1
  %across = load i64, ptr %second
  %step = mul i64 %across, %item
  store i64 %step, ptr %strides
  %last = getelementptr i64, ptr %strides, i32 1
  store i64 %item, ptr %last
  ret i32 1
trap:
  call void @llvm.trap()
  unreachable
}

declare i32 @llvm.wasm.memory.size.i32(i32)
declare i32 @llvm.wasm.memory.grow.i32(i32, i32)
declare void @llvm.trap()
"""
"""Counting of references, and memory for arrays that a function makes: they end before the entry does, the last one
first, so that memory is a stack. A block begins with its count (8 bytes) and the address of its end; at 24 bytes is the
address of its data, which follow after 64 bytes. Numba asks for another shape only to see a contiguous array as a row,
or a contiguous row as rows.
`fused` is `rounded_twice`.
"""


RESULT = 8
"""Slots before those of the arguments, for what the function returns."""


class Entry(NamedTuple):
    """A function that a page calls."""

    name: str
    function: Any
    """a dispatcher of `ecume._jit`, or a function that it admits"""
    types: tuple[Any, ...]
    """Numba's types of its arguments"""


def machine() -> Any:
    """What writes code for WebAssembly."""
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = llvm.Target.from_triple("wasm32-unknown-unknown")
    return target.create_target_machine(features=FEATURES, opt=3, reloc="static", codemodel="default")


def object_of(entries: Iterable[Entry], inlined: int | None = None) -> bytes:
    """The object file of some entries, to be linked with exp, log and pow. `inlined` is the cost up to which LLVM
    writes functions out where they are called; None: its own.
    """
    writer = machine()
    whole = llvm.parse_assembly(f'target triple = "{writer.triple}"\n{RUNTIME}')
    kept = {"memory_from"}
    for entry in entries:
        whole.link_in(llvm.parse_assembly(portable(*text_of(entry), writer)))
        kept.add(entry.name)
    for one in (*whole.functions, *whole.global_variables):
        if not one.is_declaration and one.name not in kept:
            one.linkage = "internal"
    whole.data_layout = str(writer.target_data)
    whole.verify()
    options = llvm.create_pipeline_tuning_options(speed_level=3)
    options.loop_vectorization = options.slp_vectorization = True
    if inlined is not None:
        options.inlining_threshold = inlined
    passes = llvm.create_pass_builder(writer, options)
    passes.getModulePassManager().run(whole, passes)
    emitted: bytes = writer.emit_object(whole)
    return emitted


def text_of(entry: Entry) -> tuple[str, str]:
    """Numba's text of a function, with all that it calls, and that of its entry."""
    dispatcher = entry.function.part
    # Code that is optimized for the processor has the sizes of its pointers in it: all of it must be parts.
    with libraries_are_parts(dispatcher.targetctx.codegen()):
        dispatcher.compile(entry.types)
    result = next(one for kinds, one in dispatcher.overloads.items() if tuple(kinds) == entry.types)
    context, described = result.target_context, result.fndesc
    kinds = [str(kind) for kind in context.call_conv.get_function_type(described.restype, described.argtypes).args]
    returned = str(context.call_conv.get_return_type(described.restype)).removesuffix("*")
    return str(result.library._final_module), entry_text(entry.name, described.llvm_func_name, returned, kinds[2:])


def entry_text(name: str, mangled: str, returned: str, kinds: list[str]) -> str:
    """The function `name` of the address of a block: see above. It returns Numba's status, zero if all went well.

    >>> "load double, ptr %slot0" in entry_text("root", "mangled", "double", ["double"])
    True
    """
    kinds = ["ptr" if kind.endswith("*") or kind == "ptr" else kind for kind in kinds]
    lines = [f"define i32 @{name}(ptr %block) {{", "  %failure = alloca ptr"]
    for k, kind in enumerate(kinds):
        lines += [f"  %slot{k} = getelementptr i8, ptr %block, i32 {8 * (RESULT + k)}"]
        lines += [f"  %a{k} = load {kind}, ptr %slot{k}"]
    given = "".join(f", {kind} %a{k}" for k, kind in enumerate(kinds))
    lines += ["  %at = load i32, ptr @start", "  store i32 %at, ptr @here"]
    lines += [f'  %status = call i32 @"{mangled}"(ptr %block, ptr %failure{given})', "  ret i32 %status", "}"]
    return "\n".join(lines)


RESHAPE = "numba_attempt_nocopy_reshape"
DEFINED = {"NRT_incref", "NRT_decref", "NRT_MemInfo_data_fast", "NRT_MemInfo_alloc_aligned", RESHAPE}
DECLARED = re.compile(r'^declare ([^@\n]*)@("[^"]+"|[\w.$]+)\(([^\n]*?)\)([^)\n]*)$', re.MULTILINE)


def portable(text: str, entry: str, writer: Any) -> str:
    """The text of a module for WebAssembly."""
    text = re.sub(r"^(target \w+|source_filename) = .*$", "", text, flags=re.MULTILINE)
    text = re.sub(r'"target-(cpu|features)"="[^"]*"', "", text)
    text = re.sub(r"= (common|linkonce) global ptr .*$", "= linkonce_odr global ptr null", text, flags=re.MULTILINE)
    for name in DEFINED:
        text = without_body(text, name)
    text = text.replace("@llvm.fma.f64(", "@rounded_twice(")
    text = DECLARED.sub(_or_trap, text)
    head = f'target triple = "{writer.triple}"\n@here = external global i32\n@start = external global i32\n'
    missing = [f"declare void @{name}(ptr)\n" for name in ("NRT_incref", "NRT_decref") if f"@{name}(" not in text]
    return "\n".join([head, *missing, text, entry])


def without_body(text: str, name: str) -> str:
    """The text with a declaration in the place of a function's definition."""
    found = re.search(
        rf"^define [^@\n]*?(ptr|void) @{name}\((.*?)\) [^\n]*\{{\n.*?^\}}$", text, re.MULTILINE | re.DOTALL
    )
    if found is None:
        return text
    arguments = ", ".join(one.split()[0] for one in found[2].split(",") if one.strip())
    return f"{text[: found.start()]}declare {found[1]} @{name}({arguments}){text[found.end() :]}"


def _or_trap(found: re.Match[str]) -> str:
    """What is not there for a page: a function that ends the module; the stack of the error shows its name."""
    returned, name, arguments, _ = found.groups()
    known = name.startswith("llvm.") and not name.startswith("llvm.x86")
    if known or name in PROVIDED | DEFINED | {"rounded_twice"}:
        return found[0]
    if OF_C.fullmatch(name):
        raise ValueError(f"link {name} into pages, and name it in PROVIDED: laws call it")
    plain = [
        re.sub(r"\b(noalias|writeonly|readonly|immarg|captures\(none\))\s*", "", one) for one in arguments.split(",")
    ]
    kind = returned.replace("noalias", "").strip()
    body = "call void @llvm.trap()\n  unreachable" if name != SOLVER else "ret i64 0"
    return f"define internal {kind} @{name}({', '.join(plain)}) noinline {{\n  {body}\n}}"


SOLVER = "ecume.engine.contact.active_set.nearest_impulses"
"""Python compiles it when it is first needed. A page says that it found no solution: sweeps go on until they have."""
