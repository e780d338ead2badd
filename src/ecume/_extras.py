"""How to install the packages of an extra: by their own names, so that the hint works before and after publication."""

from __future__ import annotations

import re

OF_AN_EXTRA = re.compile(r"^(?P<package>[^;]+);.*\bextra == ['\"](?P<extra>[a-z]+)['\"]")


def install(extra: str) -> str:
    """The command that installs what an extra needs: `pip install 'pandas>=2.2'`."""
    from importlib.metadata import PackageNotFoundError, requires  # not needed by `ecume --help`

    try:
        found = [OF_AN_EXTRA.match(line) for line in requires("ecume") or ()]
    except PackageNotFoundError:  # used from a folder of sources, without an installation
        found = []
    packages = [match["package"].strip() for match in found if match and match["extra"] == extra]
    return f"pip install {' '.join(map(repr, packages))}" if packages else f"pip install '.[{extra}]' in the sources"
