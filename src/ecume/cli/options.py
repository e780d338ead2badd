"""Options and arguments whose help text describes the default in words if it is not obvious."""

from __future__ import annotations

from typing import Any

import typer


def option(*names: str, **settings: Any) -> Any:
    """An option whose help does not show the default automatically."""
    return typer.Option(*names, show_default=False, **settings)


def argument(**settings: Any) -> Any:
    """An argument whose help does not show the default automatically."""
    return typer.Argument(show_default=False, **settings)
