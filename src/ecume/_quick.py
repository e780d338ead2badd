"""The small size of scripts, option `--quick`.

Benchmarks, figures and studies take minutes. With `--quick` each takes seconds, and tests only that the script runs;
its numbers and figures are meaningless. Output for the repository then goes to a temporary folder.
"""

from __future__ import annotations

import argparse
import atexit
import shutil
import sys
import tempfile
from pathlib import Path
from typing import TypeVar

Size = TypeVar("Size")

WORD = "--quick"
QUICK = WORD in sys.argv
"""Whether the quick size was requested, also in child processes, which inherit the arguments."""


def sized(full: Size, quick: Size) -> Size:
    """The size of a computation: `full`, or `quick`, which takes seconds."""
    return quick if QUICK else full


def parser_of(text: str | None) -> argparse.ArgumentParser:
    """The arguments of a script with this docstring."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        WORD, action="store_true", help="a small size, which takes seconds, to see that the script runs"
    )
    return parser


def folder_of(full: Path) -> Path:
    """The output folder of a script."""
    if not QUICK:
        return full
    place = Path(tempfile.mkdtemp(prefix="ecume-quick-"))
    atexit.register(shutil.rmtree, place, ignore_errors=True)
    return place
