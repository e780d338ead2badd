"""The friction of a contact line, which cases of drops that slide and of liquid that rises have in common."""

from __future__ import annotations

import math

SLIP = 0.134
"""The slip length at contact lines, in spacings: that with which the drop of 90 degrees slides as fast as it does.
Other angles, and the rise between plates, are compared with the same.
"""


def line_friction(angle: float, width: float, slip: float) -> float:
    """The drag (N/m) of a wedge of liquid on a plate along which its contact line moves, over viscosity and speed:
    2 sin^2(a)/(a - sin(a) cos(a)) ln(w/s).

    a: contact angle (rad); w: the width of the wedge along the plate; s: the slip length (m). [huh1971]; without a slip
    length it has no limit.

    >>> round(line_friction(math.pi / 2.0, math.e, 1.0), 4)
    1.2732
    """
    shape = 2.0 * math.sin(angle) ** 2 / (angle - math.sin(angle) * math.cos(angle))
    return shape * math.log(width / slip)
