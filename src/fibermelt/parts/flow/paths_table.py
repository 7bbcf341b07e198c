"""The table ``[paths]``: where fibers begin in a flow that is not solved here, and its stations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, Self

from pydantic import create_model, field_validator, model_validator

from fibermelt.engine.parameters import quantity, setting
from fibermelt.errors import ConfigError
from fibermelt.parts.flow.given import GivenFile
from fibermelt.units import parse_plane

__all__ = ["STATIONS", "Paths"]

STATIONS = ("entrance", "exit", "end_of_swell")
"""The keys that name the stations of a flow, zones 1 to 3."""

SPACE = 3
"""Coordinates of a point."""

_ENDS: dict[str, Any] = {
    "from": (
        tuple[float, ...],
        quantity([], "m", "First point of the line, or corner of the patch.", example="0 mm"),
    ),
    "to": (
        tuple[float, ...],
        quantity([], "m", "Last point of the line, or opposite corner.", example="3 mm"),
    ),
}
"""What Python takes for a keyword, and a person writes."""

_Ends: Any = create_model("_Ends", __base__=GivenFile, **_ENDS)


class Paths(_Ends):  # type: ignore[misc]
    """The paths of fibers through an imported flow, or a file of paths."""

    TABLE = "paths"

    file: str = setting(
        "",
        'Table of paths, with flow.source = "histories": CSV with a line for each point, columns '
        "path, time, x, y, z, u, v, w, pressure and L_xx to L_zz, units in brackets.",
        example="paths.csv",
    )
    seeds: Literal["flux", "line", "points"] = setting(
        "flux",
        "Where they begin: through a section at equal flux, evenly on a line, or at given points.",
    )
    count: int = setting(22, "Number of paths, of equal flux or along the line.", ge=1, le=10000)
    points: tuple[float, ...] = quantity(
        [],
        "m",
        "Where they begin, point by point: [[x, y, z], ...]; in a plane two coordinates will do.",
        example="1 mm",
    )
    longest: float | None = quantity(
        None,
        "s",
        "Time after which a path ends that has not left the flow; long enough to cross it a "
        "hundred times at its mean speed by default.",
        gt=0,
        example="20 s",
    )

    entrance: str = setting(
        "",
        "Plane across the flow at which the capillary begins: zone 1. Where all paths reach it, "
        "extremes are told before it (Loc. 1) besides.",
        example="y = 9 mm",
    )
    exit: str = setting(
        "", "Plane at which the melt leaves the nozzle: zone 2.", example="y = 3 mm"
    )
    end_of_swell: str = setting(
        "",
        "Plane from which on the melt moves as a whole: zone 3. Where all paths reach exit and "
        "end, extremes are told between them (Loc. 2) besides.",
        example="x = 12 mm",
    )

    @field_validator(*STATIONS)
    @classmethod
    def _planes(cls, value: str) -> str:
        """Refuse a station that is no plane."""
        if value:
            try:
                parse_plane(value)
            except ConfigError as error:
                raise ValueError(str(error)) from error
        return value

    @field_validator("points", mode="before")
    @classmethod
    def _rows(cls, value: object) -> object:
        """Take points one after the other: a list of lists is one of numbers here."""
        if not isinstance(value, (list, tuple)) or not value:
            return value
        if not all(isinstance(row, (list, tuple)) for row in value):
            return value
        flat: list[object] = []
        for k, row in enumerate(value, 1):
            if len(row) not in (SPACE - 1, SPACE):
                msg = f"point {k} has {len(row)} coordinates: give x, y and, out of a plane, z"
                raise ValueError(msg)
            flat += [*row, *[0.0] * (SPACE - len(row))]
        return flat

    @model_validator(mode="before")
    @classmethod
    def _ends(cls, data: Any) -> Any:
        """Take the two coordinates of a point in a plane with zero for the third."""
        if not isinstance(data, Mapping):
            return data
        full = dict(data)
        for name in ("from", "to"):
            point = full.get(name)
            if isinstance(point, (list, tuple)) and len(point) == SPACE - 1:
                full[name] = [*point, 0.0]
        return full

    @model_validator(mode="after")
    def _whole(self) -> Self:
        """Refuse points that are none, and a line without ends."""
        for name in ("from", "to"):
            if len(getattr(self, name)) not in (0, SPACE):
                msg = (
                    f"paths.{name} = {list(getattr(self, name))}: give x, y and, out of a plane, z"
                )
                raise ValueError(msg)
        if len(self.points) % SPACE:
            msg = f"paths.points: {len(self.points)} numbers: give [[x, y, z], ...]"
            raise ValueError(msg)
        if self.seeds == "points" and not self.points:
            msg = 'paths.seeds = "points": without paths.points: give [[x, y, z], ...]'
            raise ValueError(msg)
        ends = [name for name in ("from", "to") if not getattr(self, name)]
        if self.seeds == "line" and ends:
            msg = f'paths.seeds = "line": without paths.{ends[0]}: give both ends, from and to'
            raise ValueError(msg)
        return self
