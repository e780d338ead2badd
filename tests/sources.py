"""The files of our packages: of ecume, and of those that are installed separately."""

from pathlib import Path

import ecume
from ecume.errors import BESIDE

CORE = Path(ecume.__file__).parent
FOLDERS = (CORE, *(CORE.with_name(name) for name in BESIDE))


def source_files() -> list[Path]:
    """All Python files of our packages."""
    return sorted(path for folder in FOLDERS for path in folder.rglob("*.py"))
