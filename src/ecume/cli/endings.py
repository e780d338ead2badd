"""Endings of commands: messages on stderr, and exit codes."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import typer
import typer.core

from ecume.errors import BadInput, EcumeError, StorageError

if TYPE_CHECKING:
    pass
from ecume.cli.output import cleaned, echo

INTERRUPTED, MISUSED = 130, 2
USAGE_ERROR: type[Exception] = typer.BadParameter.__mro__[1]
"""The base class of all errors in options and arguments."""
PREFIX = "ecume: "
"""The start of every line of a message."""
WORDINGS = (
    (r"Invalid value for '?(.+?)'?: ", r"\1: "),
    (r"Input should be a valid integer.*", "expected an integer"),
    (r"Input should be a valid number.*", "expected a number"),
    (r"Input should be greater than or equal to (\S+)", r"expected \1 or more"),
    (r"Input should be less than or equal to (\S+)", r"expected \1 or less"),
    (r"(?:Value error, )?'([^']*)' is not one of (.+)", r"got '\1'; expected one of \2"),
    (r"No such (option|command):? '?([^\s']+)'?", r"\2: no such \1"),
    (r"\(Possible options: (.+)\)", r"(did you mean \1?)"),
    (r"Missing (?:option|argument|parameter) '(.+?)'\. Choose from: (.+)", r"\1: is missing; expected one of \2"),
    (r"Missing (?:option|argument|parameter) '(.+?)'.*", r"\1: is missing"),
    (r"Got unexpected extra argument(?:s|\(s\))? \((.+)\)", r"got too many arguments: \1"),
    (r"Option '(.+?)' requires an argument", r"\1: expected a value"),
)
"""The messages of the command line parser in the style of all others."""


class Ending(typer.core.TyperGroup):
    """The group of all commands. Usage errors become messages; defects of ecume keep their traceback."""

    def make_context(self, *arguments: Any, **options: Any) -> Any:
        """Parse the options, before the command runs."""
        with _usage_errors_as_messages():
            return super().make_context(*arguments, **options)

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            with _usage_errors_as_messages():
                return super().invoke(ctx)
        except EcumeError as error:
            ended = error
        except BrokenPipeError:
            raise
        except OSError as error:
            ended = StorageError(": ".join(str(part) for part in (error.filename, error.strerror or error) if part))
        except MemoryError:
            ended = BadInput("this needs more memory than the machine has")
        except KeyboardInterrupt:
            say("interrupted")
            raise typer.Exit(INTERRUPTED) from None
        say(str(ended))
        raise typer.Exit(ended.exit_code) from None


@contextmanager
def _usage_errors_as_messages() -> Iterator[None]:
    """Report faults of options and arguments in one line each, like all other messages."""
    try:
        yield
    except USAGE_ERROR as error:
        context: Any = getattr(error, "ctx", None)
        if type(error).__name__ == "NoArgsIsHelpError":  # the error message is the help text
            raise
        message: Any = getattr(error, "format_message")  # noqa: B009  # an attribute of the usage errors alone
        say(f"{_in_style(message())}; see {context.command_path if context else 'ecume'} --help")
        raise typer.Exit(MISUSED) from None


def _in_style(message: str) -> str:
    """A message of the parser, reworded.

    >>> _in_style("Invalid value for '--fps': Input should be greater than or equal to 1")
    '--fps: expected 1 or more'
    """
    message = " ".join(message.split())
    for pattern, wording in WORDINGS:
        message = re.sub(pattern, wording, message)
    return message.rstrip(".")


def say(message: str) -> None:
    """Print a message on stderr, each line with the prefix."""
    for line in cleaned(message).splitlines():
        echo(PREFIX + line, err=True)


def warned(message: Warning | str, *_: object, **__: object) -> None:
    """Print a warning as one line, instead of Python's two with a path."""
    say(f"warning: {message}")
