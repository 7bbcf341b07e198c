"""Which of a file's arrays is what, and in which unit: from names, or as a study says."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, legible, refuse_no_number, refuse_other
from fibermelt.fields.contents import Contents
from fibermelt.units import parse

__all__ = [
    "ASKED_UNITS",
    "ROLES",
    "FieldMap",
    "Scale",
    "length_scale",
    "role_scale",
    "stacked",
    "taken_for",
]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FieldMap:
    """How a file is to be read, in the words of a study's table ``[field]``.

    Parameters
    ----------
    velocity, pressure, gradient, viscosity, temperature : str
        Names of arrays; components that stand apart, with commas: ``"u, v, w"``. Empty: what has a
        usual name. The gradient's components are ``du/dx, du/dy, ...``, row by row; "none" has it
        recovered from the velocity even if the file has one.
    length_unit, velocity_unit, pressure_unit : str
        Units of a file that names none, such as "mm"; with a factor where need be, as "820 Pa" for
        a pressure over a density of 820 kg/m3. Empty: the file's, or SI where its format has none.
    pressure_zero : float
        The file's pressure in the surrounding air [Pa]: 101325 of an absolute one.
    mirror : tuple of str
        Planes of symmetry at which the file's domain ends: "y", or "y = 1.5 mm".
    axis : str
        "x" or "y" if the plane is turned about that axis, "none" if not; empty: as the file says.
    time_step : float, optional
        Time in the file's unit; the last one if none is named.
    """

    velocity: str = ""
    pressure: str = ""
    gradient: str = ""
    viscosity: str = ""
    temperature: str = ""
    length_unit: str = ""
    velocity_unit: str = ""
    pressure_unit: str = ""
    pressure_zero: float = 0.0
    mirror: tuple[str, ...] = ()
    axis: str = ""
    time_step: float | None = None

    def __post_init__(self) -> None:
        """Refuse what is no name and no number."""
        for item in fields(self):
            value = getattr(self, item.name)
            if item.name == "mirror":
                refuse_other("field.mirror", value, tuple)
            elif item.name == "pressure_zero" or (item.name == "time_step" and value is not None):
                refuse_no_number(f"field.{item.name}", value)
            elif item.name != "time_step":
                refuse_other(f"field.{item.name}", value, str)


ROLES = {
    "velocity": "m/s",
    "pressure": "Pa",
    "gradient": "1/s",
    "viscosity": "Pa s",
    "temperature": "K",
}
"""What a file may hold, and its unit."""

ASKED_UNITS = {"velocity": "velocity_unit", "pressure": "pressure_unit"}
"""Keys that give a unit, by what it is of."""

EXACT = {
    "velocity": {"u", "v", "velocity", "vel", "velocityfield", "flowvelocity", "fluidvelocity"},
    "pressure": {"p", "pressure", "staticpressure", "svp"},
    "gradient": {"velocitygradient", "gradu", "gradvelocity", "gradientvelocity", "gradientu"},
    "viscosity": {"viscosity", "mu", "spfmu", "dynamicviscosity", "molecularviscosity", "svmulam"},
    "temperature": {"t", "temperature", "statictemperature", "svt"},
}
"""Names as `_plain` has them that are certain."""

LIKELY = {
    "velocity": ("velocity",),
    "pressure": ("pressure",),
    "gradient": ("velocitygradient",),
    "viscosity": ("viscosity",),
    "temperature": ("temperature",),
}
UNLIKELY = {
    "velocity": ("gradient", "vorticity", "mesh", "error", "wall", "magnitude", "friction", "mean"),
    "pressure": ("total", "dynamic", "absolute", "coefficient", "gradient", "partial", "error"),
    "gradient": ("error",),
    "viscosity": ("turbul", "eddy", "kinematic", "effective", "ratio", "error"),
    "temperature": ("total", "gradient", "wall", "error", "reference"),
}
"""Parts of names that make an array likely to be meant, and parts that it must not have."""

LETTERS = ("xyz", "uvw", "ijk", "123", "012")
VECTOR_NAMES = ("{}velocity", "velocity{}", "sv{}", "vel{}", "{}vel", "u{}", "v{}", "{}")
"""How components that stand apart are named; ``{}`` alone is for u, v, w."""

GRADIENT_NAMES = ("d{u}velocityd{x}", "velocity{u}gradient{x}", "{u}{x}", "d{u}d{x}")
"""The same of a gradient: Fluent's, CFD-Post's, COMSOL's."""


def _plain(name: str) -> str:
    """Return a name without case, blanks and signs."""
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _components(arrays: Mapping[str, Array], width: int, *, turned: bool) -> list[str]:
    """Return the velocities whose components are arrays of their own, as ``"u, v, w"``."""
    scalars: dict[str, str] = {}
    for name, values in arrays.items():
        if values.ndim == 1:
            scalars.setdefault(_plain(name), name)
    found: list[str] = []
    taken: set[str] = set()
    for pattern in VECTOR_NAMES:
        for letters in LETTERS if pattern != "{}" else ("uvw",):
            # beside u, v stand the slopes ux, uy of COMSOL
            if pattern in {"u{}", "v{}"} and {"u", "v"} & set(scalars):
                continue
            keys = [pattern.format(letter) for letter in letters]
            if pattern == "{}" and turned and {"u", "w"} <= set(scalars):
                keys = ["u", "w"]
            present = [key for key in keys if key in scalars]
            if len(present) >= width and present == keys[: len(present)]:
                names = [scalars[key] for key in present]
                if not taken & set(names):
                    found.append(", ".join(names))
                    taken |= set(names)
    if {"axialvelocity", "radialvelocity"} <= set(scalars):
        found.append(f"{scalars['axialvelocity']}, {scalars['radialvelocity']}")
    return found


def _slopes(arrays: Mapping[str, Array], width: int) -> list[str]:
    """Return the gradients whose components are arrays of their own."""
    scalars = {_plain(name): name for name, values in arrays.items() if values.ndim == 1}
    found = []
    for pattern in GRADIENT_NAMES:
        for letters in ("xyz", "uvw"):
            keys = [pattern.format(u=u, x=x) for u in letters[:width] for x in "xyz"[:width]]
            if all(key in scalars for key in keys) and (
                pattern != "{u}{x}" or {"u", "v"} <= set(scalars)
            ):
                found.append(", ".join(scalars[key] for key in keys))
    return list(dict.fromkeys(found))


def _candidates(contents: Contents, role: str, width: int) -> list[str]:
    """Return the arrays that may be meant: the certain ones, or else the likely ones."""
    shapes = {"velocity": {2, 3}, "gradient": {4, 9}}.get(role, {1})

    def fits(values: Array) -> bool:
        count = 1 if values.ndim == 1 else values.shape[1]
        return count in shapes and not (role == "velocity" and count < width)

    named = {name: _plain(name) for name, values in contents.arrays.items() if fits(values)}
    certain = [name for name, plain in named.items() if plain in EXACT[role]]
    if role == "velocity":
        certain += _components(contents.arrays, width, turned=contents.axis == "y")
    if role == "gradient":
        certain += _slopes(contents.arrays, width)
    if certain:
        return certain
    return [
        name
        for name, plain in named.items()
        if any(part in plain for part in LIKELY[role])
        and not any(part in plain for part in UNLIKELY[role])
    ]


def _all(arrays: Mapping[str, Array]) -> str:
    """Return the arrays of a file for a message."""
    shown = ", ".join(
        f'"{legible(name, 40)}"' + (f" ({values.shape[1]})" if values.ndim > 1 else "")
        for name, values in list(arrays.items())[:20]
    )
    more = f" and {len(arrays) - 20} more" if len(arrays) > 20 else ""
    return (shown or "no array at all") + more


def _named(contents: Contents, role: str, asked: str) -> str:
    """Return the names of arrays that a study asks for, as the file writes them."""
    if asked in contents.arrays:
        return asked
    plain: dict[str, str] = {}
    for name in contents.arrays:
        plain.setdefault(_plain(name), name)
    names = []
    for part in asked.split(","):
        word = part.strip()
        name = word if word in contents.arrays else plain.get(_plain(word), "")
        if not name:
            msg = f'field.{role} = "{legible(asked)}": the file has no "{legible(word)}"; it has '
            raise ConfigError(msg + _all(contents.arrays))
        names.append(name)
    return ", ".join(names)


def taken_for(contents: Contents, wanted: FieldMap, width: int) -> tuple[dict[str, str], list[str]]:
    """Return the name of the array that is taken for each role, and what is doubtful, in words.

    Parameters
    ----------
    contents : Contents
        What the file has.
    wanted : FieldMap
        What a study says of it.
    width : int
        Directions that the flow has: 2 or 3.

    Raises
    ------
    ConfigError
        If the file has no such array as is named, no velocity, or several that may be it, or the
        pressure.
    """
    roles: dict[str, str] = {}
    notes: list[str] = []
    for role in ROLES:
        asked = getattr(wanted, role)
        if asked:
            if asked != "none":
                roles[role] = _named(contents, role, asked)
            continue
        found = _candidates(contents, role, width)
        if len(found) == 1:
            roles[role] = found[0]
        elif len(found) > 1:
            options = " or ".join(f'"{legible(name)}"' for name in found)
            if role in {"velocity", "pressure"}:
                msg = f"field.{role}: the file has {options}: say which, field.{role} = "
                raise ConfigError(msg + f'"{legible(found[0])}"')
            notes.append(f"{role}: the file has {options}; none is taken unless field.{role} says")
    if "velocity" not in roles:
        msg = "field.velocity: nothing in the file is called a velocity; it has "
        msg += _all(contents.arrays) + '; say field.velocity = "NAME", or "U, V, W" of components'
        raise ConfigError(msg)
    return roles, notes


def stacked(contents: Contents, role: str, names: str, widths: Iterable[int]) -> Array:
    """Return the values of an array, or of components side by side, (n,) or (n, c).

    Raises
    ------
    ConfigError
        If there are other components than one of ``widths``.
    """
    arrays = contents.arrays
    parts = [names] if names in arrays else [part.strip() for part in names.split(",")]
    columns = [arrays[part].reshape(len(arrays[part]), -1) for part in parts]
    values = np.concatenate(columns, axis=1).astype(np.float64, copy=False)
    if values.shape[1] not in set(widths):
        wanted = " or ".join(str(width) for width in widths)
        msg = (
            f'field.{role} = "{legible(names)}": has {values.shape[1]} components, must have '
            f"{wanted}"
        )
        raise ConfigError(msg)
    return values[:, 0] if values.shape[1] == 1 else values


@dataclass(frozen=True)
class Scale:
    """From a file's unit to SI: ``factor * value + offset``; and where the unit is from."""

    factor: float = 1.0
    offset: float = 0.0
    unit: str = ""
    is_assumed: bool = False


def _scale(unit: str, si: str) -> tuple[float, float]:
    """Return factor and offset of a unit, which may have a number before it: ``820 Pa``."""
    if re.match(r"\s*[\d.]", unit):
        return parse(unit, si), 0.0
    zero = parse(f"0 {unit}", si)
    return parse(f"1 {unit}", si) - zero, zero


def _decided(key: str, of: str, si: str, written: str, asked: str, *, names_units: bool) -> Scale:
    """Return the scale of one unit that the file writes, a study asks for, both or neither."""
    if asked:
        return _asked(key, of, si, written, asked)
    if written:
        try:
            return Scale(*_scale(written, si), written)
        except ConfigError as error:
            way = f'say field.{key} = "{si}" or what it is'
            if key == of:
                way = f'leave it out, field.{key} = "none"'
            elif of == "pressure":
                way += '; of a pressure over density, "820 Pa" with 820 kg/m3'
            msg = f"field.{key}: the file's {of} {error}: {way}"
            raise ConfigError(msg) from error
    if names_units:
        msg = (
            f"field.{key}: the file names no unit of its {of}, as its format does otherwise: say "
            f'it, such as field.{key} = "{si}"'
        )
        raise ConfigError(msg)
    return Scale(1.0, 0.0, si, is_assumed=True)


def _asked(key: str, of: str, si: str, written: str, asked: str) -> Scale:
    """Return the scale of a unit that a study asks for; what contradicts the file is refused."""
    try:
        wanted = _scale(asked, si)
    except ConfigError as error:
        msg = f'field.{key} = "{legible(asked)}" {error}'
        raise ConfigError(msg) from error
    try:
        in_file = _scale(written, si) if written else wanted
    except ConfigError:
        in_file = wanted  # a unit of another kind, which the study's is there to replace
    if not np.allclose(wanted, in_file, rtol=1e-9, atol=0):
        msg = (
            f'field.{key} = "{legible(asked)}": the file has its {of} in "{legible(written)}"; '
            "leave the key away"
        )
        raise ConfigError(msg)
    return Scale(*wanted, asked)


def length_scale(contents: Contents, wanted: FieldMap) -> Scale:
    """Return how the file's coordinates become metres."""
    return _decided(
        "length_unit",
        "coordinates",
        "m",
        contents.length_unit,
        wanted.length_unit,
        names_units=contents.names_units,
    )


def role_scale(contents: Contents, wanted: FieldMap, role: str, names: str) -> Scale:
    """Return how the values taken for a role become SI.

    A gradient whose unit nobody names is in the velocity's over the length's: that is not known
    here, and its factor is 1.
    """
    parts: Sequence[str] = [names] if names in contents.arrays else names.split(",")
    units = {contents.units.get(part.strip(), "") for part in parts}
    if len(units) > 1:
        listed = " and ".join(f'"{legible(unit)}"' for unit in sorted(units))
        msg = f'field.{role} = "{legible(names)}": the components are in {listed}, must be in one'
        raise ConfigError(msg)
    key = ASKED_UNITS.get(role, "")
    return _decided(
        key or role,
        role,
        ROLES[role],
        units.pop(),
        getattr(wanted, key) if key else "",
        names_units=contents.names_units and bool(key),
    )
