"""The papers behind a scene: those that the laws it uses name in their docstrings, as BibTeX.

>>> from ecume.scenes.templates import folder
>>> from ecume.scenes.load import load_scene
>>> papers_of(load_scene((folder() / "two-spheres.toml").read_text()))[:2]
['nicolson1949', 'chan1981']
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable
from functools import cache
from importlib.resources import files
from typing import Any

from ecume.laws import (
    brownian,
    capillarity,
    contact,
    diffusion,
    dipoles,
    drag,
    elasticity,
    ellipsoids,
    flotation,
    images,
    interfaces,
    kernels,
    lines,
    liquids,
    lubrication,
    meniscus,
    multipole,
    pace,
    pair_laws,
    quadrupoles,
    remote,
    rubbing,
    split,
    states,
    surfaces,
    viscous,
)
from ecume.models.soft import schemes
from ecume.models.sph import choosing, methods
from ecume.models.sph.substances import filled
from ecume.models.sph.tension import TENSIONS

Source = Callable[..., Any]
KEY = re.compile(r"\b[a-z]+\d{4}[a-z]?\b")


def papers_of(scene: Any) -> list[str]:
    """The keys of the papers behind the laws of a scene, in the order in which the laws come in."""
    found = [key for law in SOURCES[scene.model](scene) for key in cited(inspect.getdoc(law) or "")]
    return [key for key in dict.fromkeys(found) if key in bibliography()]


def cited(text: str) -> list[str]:
    """The keys between brackets.

    >>> cited("Friction of a pair. [morris1997, eq. 22]")
    ['morris1997']
    """
    return [key for group in re.findall(r"\[([^\]]*)\]", text) for key in KEY.findall(group)]


def bibtex(keys: Iterable[str]) -> str:
    """These entries of the bibliography."""
    return "\n\n".join(bibliography()[key] for key in keys) + "\n"


def in_words(key: str) -> str:
    """An entry as a line: authors, year, title, where."""
    entry = bibliography()[key]
    found = {name: _field(entry, name) for name in ("author", "year", "title", "journal", "publisher", "doi")}
    where = found["journal"] or found["publisher"]
    address = f"doi:{found['doi']}" if found["doi"] else ""
    parts = (found["author"], found["year"] and f"({found['year']})", f"{found['title']}.", where, address)
    return " ".join(part for part in parts if part)


def _field(entry: str, name: str) -> str:
    match = re.search(rf"\b{name}\s*=\s*[{{\"](.*?)[}}\"],?\s*$", entry, re.MULTILINE | re.DOTALL)
    return " ".join(re.sub(r"[{}\\]", "", match[1]).split()) if match else ""


@cache
def bibliography() -> dict[str, str]:
    """Every entry of the bibliography, by its key."""
    text = (files("ecume") / "references.bib").read_text(encoding="utf-8")
    return {match[1]: match[0].strip() for match in re.finditer(r"^@\w+\{(\w+),.*?^\}", text, re.MULTILINE | re.DOTALL)}


def _liquid(name: str | None) -> list[Source]:
    """The correlations of a liquid by name."""
    if not name or name not in liquids.LIQUIDS:
        return []
    return [getattr(part, "func", part) for part in liquids.LIQUIDS[name] if callable(part)]


def floating_sources(scene: Any) -> list[Source]:
    """Where floats sit, how they attract, what the dish does, drag and collisions."""
    charge = flotation.CHARGES.get(str(scene.interaction.charge))
    laws: list[Source] = [charge] if charge else []
    row = pair_laws.PAIR_LAWS.get(str(scene.interaction.law))
    laws += row.papers if row is not None else ()
    laws += [multipole.solve] if scene.interaction.method != "superposition" else []
    laws += [split.short_energy, split.smooth_wave, split.grid_error] if scene.interaction.sum == "grid" else []
    magnets = any(given.magnetic_moment for given in (*scene.floats, *scene.rows))
    laws += [dipoles.dipole_force] if magnets else []
    if scene.dish is not None:
        laws += capillarity.WALLS.get(str(scene.dish.law), ())
        laws += [meniscus.dish_height, *([images.plane_image_force] if scene.dish.image != "none" else [])]
    laws += [drag.immersion_factor, drag.stokes_friction] if scene.motion.drag else []
    if scene.shaped:
        laws += [ellipsoids.ellipsoid_undulation, lines.spread_charges, quadrupoles.quadrupole_energy]
        laws += [ellipsoids.ellipsoid_friction, ellipsoids.ellipsoid_turning_friction] if scene.motion.drag else []
    laws += [brownian.diffusivity] if scene.motion.temperature else []
    soft = scene.contacts.law == "spring-dashpot"
    return [*laws, *([contact.spring_push, contact.dashpot_restitution] if soft else [contact.impulse])]


def sph_sources(scene: Any) -> list[Source]:
    """Kernel, pressure, diffusion, friction, tension, steps: as the model chooses them."""
    liquid, name = filled(scene.liquid), choosing.diffusion_of(scene, choosing.gravity_of(scene))
    excess = methods.DIFFUSIONS[name].excess
    form = kernels.KERNELS[scene.method.kernel]
    laws: list[Source] = [form.value, states.tait_pressure, states.numerical_sound_speed]
    laws += [diffusion.strength, excess] if excess is not None else []
    laws += [viscous.artificial_viscosity] if scene.method.artificial_viscosity else []
    if liquid.viscosity or choosing.turbulent(scene):
        laws += [choosing.friction_of(scene).law]
    laws += TENSIONS[choosing.tension_of(scene)].laws
    laws += [viscous.eddy_viscosity, viscous.subparticle_stress] if choosing.turbulent(scene) else []
    return [*laws, pace.acoustic_limit, pace.force_limit, *_liquid(scene.liquid.name)]


def tracers_sources(scene: Any) -> list[Source]:
    """Drag and heat."""
    laws: dict[str, list[Source]] = {
        "stokes": [drag.stokes_friction],
        "schiller-naumann": [drag.stokes_friction, drag.schiller_naumann_factor],
    }
    heat: list[Source] = [brownian.diffusivity, brownian.displacement_variance] if scene.motion.brownian else []
    return [*laws.get(scene.motion.drag, []), *heat, *_liquid(scene.liquid.name)]


def soft_sources(scene: Any) -> list[Source]:
    """Films, surfaces, what acts across."""
    films = scene.films
    laws: list[Source] = [lubrication.squeeze_friction, lubrication.shear_friction]
    laws += [elasticity.contact_size, *surfaces.SURFACES[films.surface]]
    laws += [interfaces.INTERFACES[films.interface]] if films.interface != "rigid" else []
    laws += [rubbing.holding_force] if films.friction != "none" else []
    return [*laws, *remote.REMOTE[scene.remote.law], *SCHEME_LAWS[scene.stepping.scheme]]


SCHEME_LAWS: dict[str, list[Source]] = {"esdirk4": [schemes.esdirk4], "tr-bdf2": [schemes.tr_bdf2]}

SOURCES: dict[str, Callable[[Any], list[Source]]] = {
    "floating": floating_sources,
    "soft": soft_sources,
    "sph": sph_sources,
    "tracers": tracers_sources,
}
"""By model: the laws that a scene uses."""
