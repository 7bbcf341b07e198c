"""How a parameter of a study is declared: once, with default, range, unit, meaning and source.

From that one declaration follow the validation with its units, the commented defaults, the
resolved copy in the results folder and the reference in the documentation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import NoneType
from typing import Any, Literal, cast, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator
from pydantic.fields import FieldInfo

from fibermelt.declared import BOUNDS, HOLDS, declaration
from fibermelt.errors import ConfigError, legible
from fibermelt.units import PERCENT, celsius_meant, parse, shown

__all__ = [
    "Declaration",
    "Section",
    "Value",
    "declarations",
    "declared_by",
    "excerpt",
    "flatten",
    "quantity",
    "setting",
]

Value = float | int | str | bool | tuple[float, ...] | tuple[int, ...] | tuple[str, ...] | None
"""What a parameter can be once resolved."""


def quantity(
    default: str | float | list[str] | list[float] | None,
    unit: str,
    doc: str,
    *,
    source: str = "",
    example: str = "",
    hints: dict[str, str] | None = None,
    words: tuple[str, ...] = (),
    **bounds: float,
) -> Any:
    """Declare a physical quantity: a float in SI, or a tuple of them.

    Parameters
    ----------
    default : str, float, list of str or None
        Its value when a study does not say, as a person writes it: ``"24 mm/s"``.
    unit : str
        Its SI unit; empty for a pure number.
    doc : str
        What it is, in one sentence.
    source : str
        Where the default comes from.
    example : str
        How to write it, for error messages; the default where that is a text.
    hints : dict of str, optional
        What a value beyond a bound would mean, by the name of the bound, for error messages.
    words : tuple of str
        Texts that may stand in its place.
    **bounds : float
        ``gt``, ``ge``, ``lt``, ``le`` [unit]; of a list, those of its items. Of two bounds on one
        side a value is told the looser that it breaks: ``gt`` may say what makes no sense, ``ge``
        what is not verified.
    """
    written = (default or [None])[0] if isinstance(default, list) else default
    # pydantic bounds numbers only, not what may be a list of them or a word.
    own = isinstance(default, list) or bool(words)
    return Field(
        default=_resolved(default, unit),
        description=doc,
        validate_default=True,
        json_schema_extra={
            "quantity": True,
            "unit": unit,
            "written": list(default) if isinstance(default, list) else default,
            "source": source,
            "hints": {**(hints or {})},
            "example": example or (written if isinstance(written, str) else ""),
            "bounds": _checked(bounds) if own else {},
            "words": list(words),
        },
        **({} if own else _checked(bounds)),
    )


def setting(
    default: str | int | bool | list[str] | list[int] | None,
    doc: str,
    *,
    source: str = "",
    example: str = "",
    hints: dict[str, str] | None = None,
    **bounds: float,
) -> Any:
    """Declare what has no unit: a count, an order, a choice (a ``Literal`` type), a flag, a list.

    Parameters
    ----------
    default, doc, source, example, hints, **bounds
        As in `quantity`.
    """
    is_list = isinstance(default, list)
    return Field(
        default=tuple(default) if isinstance(default, list) else default,
        description=doc,
        json_schema_extra={
            "quantity": False,
            "unit": "",
            "written": list(default) if isinstance(default, list) else default,
            "source": source,
            "hints": {**(hints or {})},
            "example": example or (default[0] if isinstance(default, list) and default else ""),
            "bounds": _checked(bounds) if is_list else {},
            "words": [],
        },
        **({} if is_list else _checked(bounds)),
    )


def declared_by(kind: type, name: str, doc: str, shown: str = "", **more: Any) -> Any:
    """Declare what a solver's dataclass has: its default, unit and bounds are those of the field.

    Parameters
    ----------
    kind : type
        The dataclass, whose field was declared by `fibermelt.declared.declared`.
    name : str
        The field.
    doc : str
        As in `quantity`.
    shown : str
        The unit in which the default is written; its SI unit if empty.
    **more
        Other arguments of `quantity` or `setting`, bounds besides those of the field among them.
    """
    field = declaration(kind, name)
    unit, default = field.metadata["unit"], cast("int | float | None", field.default)
    more = {**field.metadata["bounds"], **more}
    if isinstance(default, int):
        return setting(default, doc, **more)
    if default is not None and shown:
        return quantity(f"{default / parse(f'1 {shown}', unit):.12g} {shown}", unit, doc, **more)
    return quantity(default, unit, doc, **more)


def _checked(bounds: dict[str, float]) -> dict[str, Any]:
    unknown = set(bounds) - set(BOUNDS)
    if unknown:
        msg = f"a parameter has no bound {sorted(unknown)}: {', '.join(BOUNDS)}"
        raise TypeError(msg)
    return dict(bounds)


def _resolved(value: object, unit: str) -> Any:
    """Return a value as written with its units resolved to SI."""
    if isinstance(value, (list, tuple)):
        return tuple(_resolved(item, unit) for item in value)
    return parse(value, unit) if value is not None else None


class Section(BaseModel):
    """A table of a study file: frozen once read, and no key in it that it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _units(cls, value: object, info: ValidationInfo) -> object:
        """Resolve the units of a quantity; a list in TOML is a tuple here."""
        extra = _extra(cls.model_fields[str(info.field_name)])
        if not extra:
            return value  # A table of its own, which says itself that it is no list.
        if isinstance(value, (list, tuple)):
            items = tuple(value)
            if extra.get("quantity"):
                items = tuple(
                    _resolved_for_pydantic(item, extra, i) for i, item in enumerate(items, 1)
                )
            for i, item in enumerate(items, 1):
                _refuse_beyond(item, extra, f"item {i} = {excerpt(item)} {extra['unit']}".rstrip())
            return items
        is_word = value in extra.get("words", ())
        if not extra.get("quantity") or is_word or isinstance(extra["written"], list):
            return value
        number = _resolved_for_pydantic(value, extra)
        _refuse_beyond(number, extra)
        return number


def _refuse_beyond(value: object, extra: Mapping[str, Any], which: str = "") -> None:
    """Refuse a number that is out of a range which pydantic does not check."""
    for name, bound in extra.get("bounds", {}).items():
        if isinstance(value, (int, float)) and not HOLDS[name](value, bound):
            hint = f" ({extra['hints'][name]})" if name in extra["hints"] else ""
            limit = f"must be {BOUNDS[name]} {bound:g} {extra['unit']}".rstrip() + hint
            limit += celsius_meant(value, extra["unit"])
            raise ValueError(f"{which}: {limit}" if which else limit)


def _resolved_for_pydantic(value: object, extra: Mapping[str, Any], item: int = 0) -> object:
    """Resolve units; pydantic collects ValueErrors, and stops at anything else."""
    try:
        # An item is one number: a list in a list is refused here, however deep it goes.
        return parse(value, str(extra["unit"])) if value is not None else None
    except ConfigError as error:
        msg = f'item {item} = "{excerpt(value)}" {error}' if item else str(error)
        msg += "".join(f'; or write "{word}"' for word in extra["words"])
        raise ValueError(msg) from error


def excerpt(value: object) -> str:
    """Return a value for a message, on one line; Python refuses to write some that TOML has."""
    try:
        return legible(str(value))
    except (ValueError, RecursionError):
        return "..."


def _extra(field: FieldInfo) -> dict[str, Any]:
    return field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}


@dataclass(frozen=True)
class Declaration:
    """One parameter, as declared: what documentation and error messages are made of."""

    key: str
    unit: str
    default: Value
    written: str | float | list[str] | list[float] | list[int] | None
    doc: str
    source: str
    hints: dict[str, str]
    example: str | int
    bounds: tuple[tuple[str, float], ...]
    words: tuple[str, ...]
    choices: tuple[str, ...]
    is_list: bool

    @property
    def written_unit(self) -> str:
        """Return the unit that the default is written in, or its example; the SI unit else."""
        written = (self.written or [None])[0] if isinstance(self.written, list) else self.written
        text = str(self.example if written is None else written)
        return text.partition(" ")[2] or self.unit if self.unit else ""

    def text(self, value: float, digits: int = 6) -> str:
        """Return an SI value as a study writes it, in the unit of its default: ``3.15 mm``."""
        if str(self.written).endswith("%"):
            return f"{PERCENT * value:.{digits}g} %"
        if not self.unit:
            return f"{value:.{digits}g}"
        unit = self.written_unit
        count = float(shown(value, self.unit, unit).partition(" ")[0])
        return f"{count:.{digits}g} {unit}"

    @property
    def range(self) -> str:
        """Return the admissible range in words: ``above 0 m`` or ``"mean" or "far-node"``."""
        each = "each " if self.is_list else ""
        if self.choices:
            return each + " or ".join(f'"{choice}"' for choice in self.choices)
        words = " and ".join(
            f"{BOUNDS[name]} {bound:g} {self.unit}".rstrip()
            for name, bound in self.bounds
            if not (name == "gt" and "ge" in dict(self.bounds))
        )
        instead = "".join(f' or "{word}"' for word in self.words)
        return each + words + instead if words else ""


def declarations(model: type[BaseModel], prefix: str = "") -> Iterator[Declaration]:
    """Yield every parameter of a model and of the sections in it, in the order of declaration."""
    for name, field in model.model_fields.items():
        key = f"{prefix}{name}"
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            yield from declarations(field.annotation, f"{key}.")
            continue
        extra = _extra(field)
        is_list = get_origin(field.annotation) is tuple
        item = get_args(field.annotation)[0] if is_list else _given(field.annotation)
        yield Declaration(
            key=key,
            unit=extra["unit"],
            default=field.default,
            written=extra["written"],
            doc=field.description or "",
            source=extra["source"],
            hints=extra["hints"],
            example=extra["example"],
            bounds=tuple(extra["bounds"].items())
            or tuple(
                (name, float(getattr(constraint, name)))
                for constraint in field.metadata
                for name in BOUNDS
                if hasattr(constraint, name)
            ),
            words=tuple(extra["words"]),
            choices=tuple(map(str, get_args(item))) if get_origin(item) is Literal else (),
            is_list=is_list,
        )


def _given(annotation: Any) -> Any:
    """Return the type of a choice that is made where it may be left out."""
    choices = [item for item in get_args(annotation) if get_origin(item) is Literal]
    return choices[0] if choices and NoneType in get_args(annotation) else annotation


def flatten(model: BaseModel, prefix: str = "") -> dict[str, Value]:
    """Return ``{"flow.gap": 0.003, ...}`` of a resolved study."""
    flat: dict[str, Value] = {}
    for name in type(model).model_fields:
        value = getattr(model, name)
        if isinstance(value, BaseModel):
            flat.update(flatten(value, f"{prefix}{name}."))
        else:
            flat[f"{prefix}{name}"] = value
    return flat
