"""All tables of a study as one value, put together from those that the parts bring."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, TypeVar

from pydantic import Field, create_model, model_validator

from fibermelt.engine.named import named
from fibermelt.engine.parameters import Section, Value, flatten, setting
from fibermelt.errors import ConfigError

if TYPE_CHECKING:
    from fibermelt.engine.parts import Lent, Part

__all__ = ["Asked", "Tables", "filled", "tables_of"]

Table = TypeVar("Table", bound=Section)


class Asked(Section):
    """What is computed: a study can be of a bead, of a single fiber, or of both."""

    parts: tuple[str, ...] = setting(["bead"], "What is computed.")

    @model_validator(mode="after")
    def _something(self) -> Self:
        """Refuse a study of nothing."""
        if not self.parts:
            msg = 'study.parts = []: name at least one, such as ["bead"]'
            raise ValueError(msg)
        return self


class Tables(Section):
    """A study, resolved: a field for each table, by its name."""

    known: ClassVar[tuple[Part, ...]] = ()
    """The parts that there are, whose tables these are."""

    study: Asked = Field(default_factory=Asked)

    @classmethod
    def lent(cls, tables: Mapping[str, Any]) -> dict[str, Lent]:
        """Return what parts lend of tables as written, by key, also where these say it."""
        return {
            key: one
            for part in cls.known
            if part.lend and any(tables.get(name) for name in part.tables)
            for key, one in named(part.lend)(tables).items()
        }

    @model_validator(mode="before")
    @classmethod
    def _filled(cls, data: Any) -> Any:
        """Fill in what parts lend and the study does not say."""
        return filled(data, cls.lent(data)) if isinstance(data, Mapping) else data

    @property
    def asked(self) -> tuple[Part, ...]:
        """Return the parts that the study asks for."""
        return tuple(part for part in self.known if part.name in self.study.parts)

    def table(self, kind: type[Table]) -> Table:
        """Return the table of a kind."""
        found: Table = next(
            value
            for name in type(self).model_fields
            if isinstance(value := getattr(self, name), kind)
        )
        return found

    def values(self) -> dict[str, Value]:
        """Return all that stages can read: ``{"flow.gap": 0.003, ...}``, and what parts derive."""
        values = flatten(self)
        for part in self.known:
            if part.derive:
                values |= named(part.derive)(self)
        return values

    def notes(self) -> list[str]:
        """Return what a person should know of a study that is allowed, and perhaps not meant."""
        return [note for part in self.known if part.notes for note in named(part.notes)(self)]

    @model_validator(mode="after")
    def _allowed(self) -> Self:
        """Refuse what a part cannot do with, before anything is computed."""
        for part in self.known:
            if part.refuse:
                try:
                    named(part.refuse)(self)
                except ConfigError as error:
                    raise ValueError(str(error)) from error
        return self


def filled(tables: Mapping[str, Any], lent: Mapping[str, Lent]) -> dict[str, Any]:
    """Return tables as written with what is lent to those of their keys that they leave out.

    A table that was read before is whole.
    """
    whole = dict(tables)
    for key, one in lent.items():
        table, _, name = key.partition(".")
        own = whole.get(table, {})
        if isinstance(own, Mapping) and own.get(name) is None:
            whole[table] = {**own, name: one.value}
    return whole


def tables_of(parts: Sequence[Part]) -> type[Tables]:
    """Return the class of studies that are made of some parts.

    Parameters
    ----------
    parts : sequence of Part
        What they bring. Tables of one name are one table, with the keys of all.
    """
    kinds: dict[str, list[type[Section]]] = {"study": [_asked(parts)]}
    for part in parts:
        for name, kind in part.tables.items():
            kinds.setdefault(name, []).append(kind)
    fields: dict[str, Any] = {}
    for name, found in kinds.items():
        kind = found[0] if len(found) == 1 else _joined(found)
        fields[name] = (kind, Field(default_factory=kind))
    made: type[Tables] = create_model("Study", __base__=Tables, **fields)
    made.known = tuple(parts)
    return made


def _joined(kinds: Sequence[type[Section]]) -> type[Section]:
    """Return a table that has the keys of several, in their order."""
    # Of several bases the fields of the last come first.
    return create_model(
        kinds[0].__name__, __base__=tuple(reversed(kinds)), __doc__=kinds[0].__doc__
    )


def _asked(parts: Sequence[Part]) -> type[Asked]:
    """Return the table that names parts, with what each computes in its words."""
    asked = [part for part in parts if part.meaning]
    names = tuple(part.name for part in asked)
    told = "; ".join(f'"{part.name}": {part.meaning}' for part in asked)
    choice = tuple[Literal[names], ...]  # type: ignore[valid-type]
    default = list(names[:1])
    return create_model(
        "Asked",
        __base__=Asked,
        __doc__=Asked.__doc__,
        parts=(choice, setting(default, f"What is computed. {told}.")),
    )
