"""The end of a command: one clear message on stderr, and an exit code that a script can rely on."""

from __future__ import annotations

from typing import Any

import typer
import typer.core

from ecume.errors import BadInput, EcumeError, SceneError, StorageError

INTERRUPTED = 130
CONTROL = {code: None for code in (*range(0x20), 0x7F, *range(0x80, 0xA0)) if code != ord("\n")}


class Ending(typer.core.TyperGroup):
    """The group of all verbs. What is an answer to the user becomes a message; a defect of ours keeps its traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run a verb."""
        try:
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
        say(str(ended), named=not isinstance(ended, SceneError))
        raise typer.Exit(ended.exit_code) from None


def say(message: str, *, named: bool = True) -> None:
    """A message for the person, on stderr; names from files cannot steer the terminal. A file's faults name it."""
    typer.echo(("ecume: " if named else "") + message.translate(CONTROL), err=True)


def warned(message: Warning | str, *_: object, **__: object) -> None:
    """A warning as a line, in place of Python's two with a path in them."""
    say(f"warning: {message}")
