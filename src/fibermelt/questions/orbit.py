"""One fiber in simple shear, over one turn: what `fibermelt orbit` answers.

What loads the finite elements is imported where it is used.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

from fibermelt.engine.parameters import declarations
from fibermelt.errors import ConfigError
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.newton import FreeFiber, NewtonSolver
from fibermelt.fiber.newton_orbit import orbit_newton
from fibermelt.fiber.orbit import checked_shear, orbit
from fibermelt.fiber.shape import Ellipse
from fibermelt.melt import LAWS
from fibermelt.paper.config import Sensitivity
from fibermelt.parts.bead.shape import Sizes
from fibermelt.parts.bead.shapes import SHAPES, choices
from fibermelt.parts.melt.melt import NEWTONIAN
from fibermelt.parts.melt.values import CONSTANTS, OPTIONAL, Constants
from fibermelt.units import parse

if TYPE_CHECKING:
    from fibermelt.fiber.orbit import Orbit
    from fibermelt.fiber.response import FiberResponse
    from fibermelt.fiber.thinning import ThinningResponse
    from fibermelt.melt import ViscosityLaw

__all__ = ["PATHS", "OrbitStudy", "orbit_in_words", "read_melt", "read_quantity", "run_orbit"]

ORBIT_LAWS = tuple(name for name in CONSTANTS if name != "cross-wlf")
"""Laws of a melt at one temperature."""

PAPER_DOMAIN = 4.0
"""The paper's domain-size factor ``M`` [-], section 2.5."""

PATHS = ("superposition", "newton")
"""Ways to the answer: the cell's two flows, exact in the angle, or the paper's own algorithm."""

KEYS = (
    "period",
    "period_jeffery",
    "shape_factor",
    "stalls",
    "stall_angle",
    "max_pressure",
    "min_pressure",
    "tip_max",
    "tip_min",
    "angle_at_min",
    "where_at_min",
)
"""What is said of an orbit; its cost comes last."""


@dataclass(frozen=True)
class OrbitStudy:
    """A fiber in the simple shear ``u_x = gamma_dot y``.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-], at least one.
    shear_rate : float
        ``gamma_dot`` [1/s], positive.
    viscosity : float or ViscosityLaw
        ``mu`` of the melt [Pa s], positive, or its law.
    model : str
        One of `fibermelt.parts.bead.shapes.SHAPES`.
    domain_size : float, optional
        ``M`` of the confined ellipse [-], above 2; the paper's if not given. The other models have
        no cell, and take none.
    angle : float
        Angle from the flow direction at the start [rad].
    path : str
        One of `PATHS`; the paper's algorithm needs a cell.
    """

    aspect_ratio: float
    shear_rate: float
    viscosity: float | ViscosityLaw
    model: str = next(iter(SHAPES))
    domain_size: float | None = None
    angle: float = 0.0
    path: str = "superposition"


def read_quantity(option: str, text: str, unit: str, bare: str = "") -> float:
    """Return the quantity that an option of the command line says, in SI.

    Parameters
    ----------
    option : str
        Its name, for the message.
    text : str
        A number, or a number with a unit: ``1``, ``"1 1/s"``.
    unit : str
        The SI unit.
    bare : str
        The unit of a number without one; the SI unit if empty.

    Raises
    ------
    ConfigError
        If it is neither, or of another dimension, or not finite.
    """
    try:
        return parse(_with_unit(text, bare), unit)
    except ConfigError as error:
        msg = f'{option} = "{text}": {error}'
        raise ConfigError(msg) from None


def _with_unit(text: str, bare: str) -> str | float:
    """Return a number as one, or with the unit that it has when none is written."""
    try:
        number = float(text)
    except ValueError:
        return text
    return f"{text} {bare}" if bare and math.isfinite(number) else number


def run_orbit(study: OrbitStudy) -> dict[str, Any]:
    """Return period, shape factor and pressure extremes of a fiber's orbit, in SI.

    Parameters
    ----------
    study : OrbitStudy
        The fiber and the flow.

    Returns
    -------
    dict
        ``model`` and ``domain_size`` M (None without a cell), ``period`` [s] (None if it
        stalls), ``period_jeffery`` [s], ``shape_factor``, ``stalls``,
        ``stall_angle`` [rad], pressures relative to the far field's [Pa] over the orbit (half a
        turn if it stalls), ``angle_at_min`` and ``where_at_min`` [rad] (None for a circle or a
        sphere, which has the same lowest pressure at every angle), and ``cost``: the seconds of
        the cell, the orbit and both, the orientations that were sampled and the linear solves they
        took (none where the answer is exact).

    Raises
    ------
    ConfigError
        If a parameter is out of its range, or the path does not go with the model.
    ConvergenceError
        As in `fibermelt.fiber.orbit_newton`.
    """
    for name, value, known in (("model", study.model, SHAPES), ("path", study.path, PATHS)):
        if value not in known:
            words = " or ".join(f'"{choice}"' for choice in known)
            msg = f'{name} = "{value}": must be {words}'
            raise ConfigError(msg)
    checked_shear(study.shear_rate, _newtonian(study), study.angle)
    newton, shape = study.path == "newton", SHAPES[study.model]
    if newton and not shape.has_cell:
        msg = (
            f'path = "newton": the paper\'s algorithm works on a cell, which model = '
            f'"{study.model}" has not: take model {choices("has_cell")}, or path "superposition"'
        )
        raise ConfigError(msg)
    if shape.has_thickness:
        msg = (
            f'model = "{shape.name}": turns about all its axes and has no one orbit: take model '
            f'"{shape.instead}"'
        )
        raise ConfigError(msg)
    if not shape.has_cell and study.domain_size is not None:
        msg = (
            f'domain_size = {study.domain_size:g} with model = "{study.model}": that model has no '
            f"cell, which a domain size could be of: drop it, or take model {choices('has_cell')}"
        )
        raise ConfigError(msg)
    found, cell, turn = _newton(study) if newton else _superposition(study)
    cost = {
        "cell": cell,
        "orbit": turn,
        "total": cell + turn,
        "steps": found.steps,
        "solves": found.solves,
    }
    answer = {key: getattr(found, key) for key in KEYS}
    if study.aspect_ratio == 1.0:
        # A circle has no direction: which angle comes out lowest is rounding.
        answer |= {"angle_at_min": None, "where_at_min": None}
    size = _domain(study) if shape.has_cell else None
    return {"model": study.model, "domain_size": size, **answer, "cost": cost}


def _domain(study: OrbitStudy) -> float:
    return PAPER_DOMAIN if study.domain_size is None else study.domain_size


def read_melt(law: str | None, said: Mapping[str, str | None]) -> float | ViscosityLaw:
    """Return the melt that the command line says.

    Parameters
    ----------
    law : str, optional
        Name of its law; Newtonian if not given.
    said : mapping
        Constants by the names that the law has for them, as written; None for those that are not.

    Raises
    ------
    ConfigError
        If there is no such law, or a constant is missing, another law's, or out of its range.
    """
    name = NEWTONIAN if law is None else law
    if name not in ORBIT_LAWS:
        known = ", ".join(f'"{one}"' for one in ORBIT_LAWS)
        msg = f'--law "{name}": must be one of {known}'
        raise ConfigError(msg)
    units = {item.key: item.unit for item in declarations(Constants)}
    given = {key: text for key, text in said.items() if text is not None}
    options = {key: f"--{key.replace('_', '-')}" for key in said}
    if wrong := [options[key] for key in given if key not in CONSTANTS[name]]:
        has = ", ".join(options[key] for key in CONSTANTS[name] if key in options)
        msg = f"{', '.join(wrong)}: no constant of the law {name}, which has {has}"
        raise ConfigError(msg)
    needed = [key for key in CONSTANTS[name] if key not in OPTIONAL and key not in given]
    if needed:
        msg = f"{', '.join(options[key] for key in needed)}: missing: the law {name} needs it"
        raise ConfigError(msg)
    values = {key: read_quantity(options[key], text, units[key]) for key, text in given.items()}
    if name == NEWTONIAN:
        return values["viscosity"]
    try:
        return LAWS[name](**values)
    except ConfigError as error:
        msg = re.sub(r"melt\.(\w+)", lambda found: options.get(found[1], found[0]), str(error))
        raise ConfigError(msg) from None


def _law_of(study: OrbitStudy) -> ViscosityLaw | None:
    """Return the law of a melt that thins, None of a Newtonian one."""
    melt = study.viscosity
    return None if isinstance(melt, float | int) or melt.is_newtonian else melt


def _newtonian(study: OrbitStudy) -> float:
    """Return the viscosity [Pa s] of a Newtonian melt; 1 of another, whose law has its units."""
    melt = study.viscosity
    if isinstance(melt, float | int):
        return float(melt)
    return float(melt.viscosity_at(1.0)) if melt.is_newtonian else 1.0


def _superposition(study: OrbitStudy) -> tuple[Orbit, float, float]:
    """Return the orbit from the fiber's response, and the seconds that both took."""
    start = perf_counter()
    response = _response(study)
    middle = perf_counter()
    found = orbit(response, study.shear_rate, study.viscosity, study.angle)
    return found, middle - start, perf_counter() - middle


def _response(study: OrbitStudy) -> FiberResponse | ThinningResponse:
    """Return the fiber's answer: of its cell, of a melt without end, or of a melt that thins."""
    shape, sizes, law = SHAPES[study.model], Sizes(1.0, study.aspect_ratio), _law_of(study)
    if law is None:
        return shape.model(sizes, _domain(study), CellNumerics(estimate=False)).response
    from fibermelt.fiber.cell.thinning import THINNING_NUMERICS  # noqa: PLC0415  a second's import

    numerics = replace(THINNING_NUMERICS, estimate=False)
    return shape.thinning(
        sizes, law, _domain(study), numerics, (study.shear_rate, study.shear_rate)
    )


def _newton(study: OrbitStudy) -> tuple[Orbit, float, float]:
    """Return the orbit by the paper's algorithm, and the seconds of cell and orbit."""
    from fibermelt.fiber.cell import ThinningFiber, build_system  # noqa: PLC0415  lazy, as above

    free: FreeFiber
    fiber, law, start = Ellipse(1.0, study.aspect_ratio), _law_of(study), perf_counter()
    if law is None:
        free = NewtonSolver(build_system(fiber, _domain(study)))
    else:
        free = ThinningFiber(fiber, _domain(study), law)
    middle = perf_counter()
    found = orbit_newton(free, study.shear_rate, _newtonian(study), study.angle)
    return found, middle - start, perf_counter() - middle


def orbit_in_words(answer: Mapping[str, Any]) -> str:
    """Return what `run_orbit` found as a few lines for a person."""
    jeffery = f"{answer['period_jeffery']:.6g} s for the same fiber in an unbounded Newtonian melt"
    if answer["stalls"]:
        turning = f"none: it stalls at {math.degrees(answer['stall_angle']):.3f} deg ({jeffery})"
    else:
        turning = f"{answer['period']:.6g} s ({jeffery})"
    return "\n".join(
        [
            *_fiber(answer),
            f"shape factor    {round(answer['shape_factor'], 6) + 0.0:.6f}",
            f"period          {turning}",
            f"surface         {answer['min_pressure']:.6g} to {answer['max_pressure']:.6g} Pa",
            f"tips            {answer['tip_min']:.6g} to {answer['tip_max']:.6g} Pa",
            f"lowest          {_lowest(answer)}",
            f"cost            {answer['cost']['total']:.2f} s",
        ]
    )


def _fiber(answer: Mapping[str, Any]) -> list[str]:
    """Return what the answer stands for: the fiber's surroundings decide its pressures."""
    size = answer["domain_size"]
    if size is None:
        return [f"fiber           {answer['model']} in an unbounded melt"]
    cell = f"fiber           ellipse in a cell of M = {size:g}"
    if size != PAPER_DOMAIN:
        return [cell]
    shear = Sensitivity.model_fields["domain_size"].default
    return [
        f"{cell}, the paper's for the bead; its Table 1 and Fig. 9,",
        f"                and the report's chapter on them, go with --domain-size {shear:g}",
    ]


def _lowest(answer: Mapping[str, Any]) -> str:
    """Return where the lowest pressure is met, in words."""
    if answer["angle_at_min"] is None:
        return "at every angle alike: a fiber of aspect ratio 1 has no direction"
    # the sum takes the sign off a zero
    angle, where = (
        round(math.degrees(answer[key]), 2) + 0.0 for key in ("angle_at_min", "where_at_min")
    )
    return f"at {angle:.2f} deg to the flow, at the eccentric angle {where:.2f} deg"
