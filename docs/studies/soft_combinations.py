"""Every imposed motion or stress of a packing with every resistance: which combinations run, and why others are
refused.

`python docs/studies/soft_combinations.py` runs eight spheres for each combination, writes `recorded-combinations.csv`
beside this file and prints the table of `docs/physics/soft.md`; some minutes.
"""

from __future__ import annotations

import csv
import itertools
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ecume._quick import folder_of, parser_of, sized
from ecume.errors import EcumeError
from ecume.scenes.schema import Scene, from_plain
from ecume.simulation import simulate

RECORDED = Path(__file__).parent / "recorded-combinations.csv"
WRITTEN = folder_of(RECORDED.parent) / RECORDED.name
DURATION = 0.02
SHEARS: dict[str, list[dict[str, Any]]] = {
    "strain": [{"time": 0.0}, {"time": DURATION, "strain": 0.002}],
    "shear rate": [{"time": 0.0, "shear_rate": 0.1}],
    "shear stress": [{"time": 0.0, "shear_stress": 1e-4}],
    "oscillation": [{"time": 0.0, "oscillation": {"frequency": 1.0 / DURATION, "amplitude": 1e-3}}],
}
SIZES: dict[str, dict[str, float]] = {
    "constant size": {},
    "height rate": {"height_rate": -0.1},
    "normal stress": {"normal_stress": 1e-3},
    "pressure": {"pressure": 1e-3},
}
BOTTOM = {"side": "bottom"}
OTHERS: dict[str, dict[str, Any]] = {
    "walls that press": {"walls": [BOTTOM, {"side": "top", "pressure": 1e-3}]},
    "walls that press and shear": {"walls": [BOTTOM, {"side": "top", "pressure": 1e-3, "shear_stress": 1e-4}]},
    "a wall that glides": {"walls": [BOTTOM, {"side": "top", "velocity": [0.5, 0.0]}]},
    "gravity above a wall": {"walls": [BOTTOM], "gravity": 1.0},
    "gravity in a periodic cell": {"gravity": 1.0},
    "forces that balance": {"pulls": (1e-4, -1e-4)},
    "forces that do not balance": {"pulls": (1e-4, 0.0)},
}
RESISTS = ("drag", "rotation", "friction", "long-range force")
EVERY = sized(1, 100)
"""One in so many combinations is run."""
LARGEST_IMBALANCE = 1e-7


def imposed() -> Iterator[tuple[str, dict[str, Any]]]:
    """What is imposed, by its name."""
    for (shear, (first, *rest)), (size, more) in itertools.product(SHEARS.items(), SIZES.items()):
        yield f"{shear}, {size}", {"protocol": [first | more, *rest]}
    yield from OTHERS.items()


def scene_of(given: dict[str, Any], drag: bool, rotation: bool, friction: bool, force: bool) -> Scene:
    """Eight spheres of two sizes in 2D."""
    heavy = {"density": 1.001} if "gravity" in given else {}
    pulls = given.get("pulls", (None, None))
    particles = [
        {"radius": radius, "modulus": 1.0, "count": 4, **heavy, **({} if pull is None else {"force": [pull, 0.0]})}
        for radius, pull in zip((1.0, 1.3), pulls, strict=True)
    ]
    return from_plain({
        "model": "soft", "duration": DURATION, "frame_every": 0.5 * DURATION, "seed": 3, "rotation": rotation,
        "liquid": {"viscosity": 1e-3, "density": 1.0}, "particles": particles,
        "hydrodynamics": {"drag": "stokes" if drag else "none"},
        "films": {"friction": "coulomb", "roughness": 0.05} if friction else {},
        "long_range_forces": {"law": "steric", "steric_strength": 1e-3, "steric_length": 0.03} if force else {},
        "cell": {"size": [1.0, 1.0], "volume_fraction": 0.6 if "walls" in given else 0.8},
        "integration": {"integrator": "tr-bdf2", "tolerance": 1e-3},
        **{key: value for key, value in given.items() if key != "pulls"},
    })  # fmt: skip


def outcome(scene: Scene) -> str:
    """What becomes of a scene: "runs", or why it is refused or ends."""
    try:
        worst = max(frame.numbers["imbalance"] for frame in simulate(scene))
    except EcumeError as error:
        return str(error).removeprefix("scene: ")
    return "runs" if worst < LARGEST_IMBALANCE else f"leaves {worst:.1e} of the force on a sphere"


def table() -> str:
    """The recorded outcomes: a row for what is imposed, a column for each drag and rotation."""
    with WRITTEN.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    reasons: list[str] = []
    lines = [
        "| imposed | neither drag nor rotation | rotation | drag | drag and rotation |", "|---|:-:|:-:|:-:|:-:|"
    ]  # fmt: skip
    for name in dict.fromkeys(row["imposed"] for row in rows):
        cells = []
        for drag, rotation in (("0", "0"), ("0", "1"), ("1", "0"), ("1", "1")):
            mine = [row for row in rows if (row["imposed"], row["drag"], row["rotation"]) == (name, drag, rotation)]
            for reason in dict.fromkeys(row["outcome"] for row in mine if row["outcome"] != "runs"):
                reasons += [] if reason in reasons else [reason]
            found = {"·" if row["outcome"] == "runs" else "abcdefgh"[reasons.index(row["outcome"])] for row in mine}
            cells.append(" ".join(sorted(found)))
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(
        [*lines, "", *(f"- {letter}: {reason}" for letter, reason in zip("abcdefgh", reasons, strict=False))]
    )


def main() -> None:
    """Run all combinations, and print the table."""
    every = itertools.product(imposed(), itertools.product((False, True), repeat=len(RESISTS)))
    with WRITTEN.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["imposed", *RESISTS, "outcome"])
        for (name, given), resists in itertools.islice(every, 0, None, EVERY):
            writer.writerow([name, *map(int, resists), outcome(scene_of(given, *resists))])
    sys.stdout.write(f"{table()}\n")


if __name__ == "__main__":
    parser_of(__doc__).parse_args()
    main()
