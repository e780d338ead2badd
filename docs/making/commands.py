"""The reference of the command line, from the commands themselves."""

from __future__ import annotations

import inspect
import re
from typing import Any

import typer.main
from writing import cell

from ecume.cli import app


def pages() -> dict[str, str]:
    """One page with every verb."""
    group = typer.main.get_command(app)
    listed = {name: command for name, command in group.commands.items() if not command.hidden}
    epilog = inspect.cleandoc(str(app.info.epilog))
    head = f"# Commands\n\n{epilog}\n\n`ecume --help` and `ecume VERB --help` print the same in the terminal."
    return {
        "reference/commands.md": "\n\n".join([head, *(_verb(name, command) for name, command in listed.items())]) + "\n"
    }


def _verb(name: str, command: Any) -> str:
    says = re.sub(r"\b(Examples?): ", r"\n\n\1: ", inspect.cleandoc(command.help or ""))
    rows = [_row(one) for one in command.params if not getattr(one, "hidden", False) and one.name != "help"]
    table = ["| argument | meaning |", "|---|---|", *rows] if rows else []
    return "\n".join([f"## ecume {name}", "", says, "", *table])


def _row(one: Any) -> str:
    names = (
        ", ".join(f"`{name}`" for name in one.opts)
        if one.param_type_name == "option"
        else f"`{one.metavar or one.name.upper()}`"
    )
    value = f" `{one.metavar}`" if one.param_type_name == "option" and one.metavar else ""
    usual = (
        f" Default: {one.default}."
        if one.show_default
        and one.default not in (None, False, (), [], ...)
        and isinstance(one.default, (int, float, str))
        else ""
    )
    return f"| {cell(names + value)} | {cell((one.help or '') + usual)} |"
