"""Each undocumented name of Numba that the compiler layer uses exists: an upgrade without it fails here, by name."""

import ast
import importlib
import re
from pathlib import Path

import numba
import pytest

import ecume

pytestmark = pytest.mark.compiled
PACKAGE = Path(ecume.__file__).parent
FILES = [
    one for one in sorted(PACKAGE.glob("_*.py")) if re.search(r"^ *(from|import) numba", one.read_text("utf-8"), re.M)
]
PRIVATE = {
    "_optimize_functions": ("numba.core.codegen", "JITCodeLibrary", "parts are not optimized where they stand"),
    "_optimize_final_module": ("numba.core.codegen", "JITCodeLibrary", "parts are not optimized where they stand"),
    "_finalize_final_module": ("numba.core.codegen", "JITCodeLibrary", "parts are not made ready to run"),
    "_ensure_finalized": ("numba.core.codegen", "JITCodeLibrary", "a part is complete before it is linked"),
    "_function_pass_manager": (
        "numba.core.codegen",
        "JITCPUCodegen",
        "declared functions are left alone",
    ),
    "_library_class": ("numba.core.codegen", "JITCPUCodegen", "libraries made inside a whole are parts"),
    "_find_referenced_environments": ("numba.core.compiler", "CompileResult", "parts get their environments"),
    "_reduce": ("numba.core.compiler", "CompileResult", "what the disk cache stores"),
    "_rebuild": ("numba.core.compiler", "CompileResult", "what the disk cache reads"),
}
"""By name: module and class of Numba that have it, and what it is used for."""
OF_OBJECTS = {"_finalized", "_codegen", "_data_layout", "_cache", "_is_initialized"}
"""Names that exist on objects only: the tests below look at them."""


@pytest.mark.parametrize("name", PRIVATE)
def test_numba_has_each_private_name_of_a_class(name):
    module, owner, purpose = PRIVATE[name]
    found = hasattr(getattr(importlib.import_module(module), owner), name)
    assert found, f"Numba {numba.__version__} has no {module}.{owner}.{name}, by which {purpose}"


def imported():
    """Each name that the compiler layer imports from Numba or llvmlite, with its module."""
    for file in FILES:
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in {"numba", "llvmlite"}:
                yield from ((file.name, node.module, one.name) for one in node.names)


@pytest.mark.parametrize(("file", "module", "name"), sorted(set(imported())))
def test_numba_has_each_name_that_is_imported(file, module, name):
    try:
        found = hasattr(importlib.import_module(module), name) or importlib.import_module(f"{module}.{name}")
    except ImportError:
        found = False
    assert found, f"Numba {numba.__version__} has no {module}.{name}, which {file} imports"


def test_numba_has_each_private_name_of_an_object():
    from numba.core.registry import cpu_target
    from numba.np.ufunc import parallel

    from ecume._jit import compiled_once

    @compiled_once
    def one():
        return 1

    assert one() == 1
    codegen, library = cpu_target.target_context.codegen(), one.overloads[()].library
    owners = {"_finalized": library, "_codegen": library, "_data_layout": codegen, "_cache": one}
    missing = {name for name, owner in owners.items() if not hasattr(owner, name)}
    numba.get_num_threads()
    missing |= set() if hasattr(parallel, "_is_initialized") else {"_is_initialized"}
    assert not missing, f"Numba {numba.__version__} has other names for {sorted(missing)}"
    assert set(owners) | {"_is_initialized"} == OF_OBJECTS


def test_no_private_name_is_used_that_is_not_listed_here():
    used = set()
    for file in FILES:
        tree = ast.parse(file.read_text("utf-8"))
        own = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name not in PRIVATE}
        own |= {
            node.attr for node in ast.walk(tree)
            if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and node.attr not in PRIVATE
        }  # fmt: skip
        names = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
        names |= {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and node.value in OF_OBJECTS}
        names |= {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)} & set(PRIVATE)
        used |= {name for name in names if re.match(r"_[a-z]", name)} - (own - OF_OBJECTS)
    assert used == set(PRIVATE) | OF_OBJECTS
