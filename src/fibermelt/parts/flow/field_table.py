"""The table ``[field]``: another solver's flow, its names and units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from fibermelt.engine.parameters import quantity, setting
from fibermelt.parts.flow.given import GivenFile

if TYPE_CHECKING:
    from fibermelt.fields.mapping import FieldMap

__all__ = ["ImportedField"]


class ImportedField(GivenFile):
    """Another solver's file that the flow is read from; `fibermelt fields` says what is in it."""

    TABLE = "field"

    file: str = setting(
        "",
        "The file, from the working directory; of OpenFOAM the case's folder.",
        example="nozzle.csv",
    )
    velocity: str = setting(
        "",
        "Array of the velocity; components that stand apart, with commas. Empty: what has a usual "
        "name.",
        example="u, v, w",
    )
    pressure: str = setting(
        "", "Array of the pressure. Empty: what has a usual name.", example="Pressure"
    )
    gradient: str = setting(
        "",
        "Array of the velocity gradient, du/dx, du/dy, ... row by row. Empty: what has a usual "
        'name, recovered from the velocity if nothing has; "none": recovered in any case.',
        example="none",
    )
    viscosity: str = setting(
        "", "Array of the viscosity. Empty: what has a usual name.", example="Viscosity"
    )
    temperature: str = setting(
        "", "Array of the temperature. Empty: what has a usual name.", example="Temperature"
    )
    length_unit: str = setting(
        "",
        "Unit of the coordinates. Empty: the file's, or m where its format has none.",
        example="mm",
    )
    velocity_unit: str = setting(
        "",
        "Unit of the velocity. Empty: the file's, or m/s where its format has none.",
        example="mm/s",
    )
    pressure_unit: str = setting(
        "",
        'Unit of the pressure; of one over density with a factor, such as "820 Pa" for 820 kg/m3. '
        "Empty: the file's, or Pa where its format has none.",
        example="MPa",
    )
    pressure_zero: float = quantity(
        "0 Pa", "Pa", "Pressure in the file where the surrounding air is.", example="101325 Pa"
    )
    mirror: tuple[str, ...] = setting(
        [], "Planes of symmetry at which the file's domain ends.", example="y = 1.5 mm"
    )
    axis: Literal["", "x", "y", "none"] = setting(
        "", "Axis that a planar file is turned about. Empty: as the file says."
    )
    time_step: float | None = setting(
        None, "Time that is read, in the file's unit; the last one if left out.", example="0.5"
    )

    def as_map(self) -> FieldMap:
        """Return what the table says of the file, for `fibermelt.fields.reading.read_field`."""
        from fibermelt.fields.mapping import FieldMap  # noqa: PLC0415  lazy: NumPy

        return FieldMap(**{name: getattr(self, name) for name in FieldMap.__dataclass_fields__})
