"""User-defined laws of a scene: their names only. The code is given on the command line or in Python."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ecume.scenes.quantities import STRICT, Text
from ecume.scenes.validated import dataclass

LawName = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=80)]
Constant = Annotated[float, Field(ge=-1e300, le=1e300)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class UserLawSpec:
    """A user-defined law, by the name of its function."""

    law: LawName
    """The name of the function, which `--laws FILE.py` or `extra_laws` provides. Example: `"yukawa"`. Effect: adds its
    force to the scene; without the file the scene is refused."""
    species: tuple[Text, ...] = ()
    """The species that it acts on: two names for the force of a pair, one for an external force; by default all.
    Example: `["oats", "nuts"]`. Effect: other species do not feel the law."""
    constants: tuple[Constant, ...] = ()
    """The numbers that the function reads as `parameters.constants`, in SI units. Example: `[1e-8, 4e-3]`.
    Effect: they set strength and range, as the function defines."""
