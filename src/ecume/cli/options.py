"""Options and arguments whose help states the default in words, where it is not obvious."""

from __future__ import annotations

from typing import Any

import typer


def option(*names: str, **settings: Any) -> Any:
    """An option whose help shows no further default."""
    return typer.Option(*names, show_default=False, **settings)


def argument(**settings: Any) -> Any:
    """An argument whose help shows no further default."""
    return typer.Argument(show_default=False, **settings)
