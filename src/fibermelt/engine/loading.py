"""From what a person wrote to a resolved study: presets, files, overrides, and what is wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fibermelt.engine.messages import explain
from fibermelt.engine.named import named
from fibermelt.engine.overrides import (
    plain,
    read_overrides,
    read_tables,
    read_varying,
    refuse_without_effect,
    varied,
)
from fibermelt.engine.parameters import declarations, excerpt
from fibermelt.engine.syntax import parse_toml, read_toml
from fibermelt.engine.tables import Tables, filled
from fibermelt.errors import ConfigError, legible

__all__ = ["Reader", "Study"]

_LONGEST_PATH = 200

IN_PYTHON = "unnamed"
"""The name of a study that has no file."""


@dataclass(frozen=True)
class Study:
    """A study that can be run.

    Parameters
    ----------
    name : str
        Its name.
    origin : str
        Where it came from, in words.
    config : Tables
        Its resolved parameters.
    path : Path, optional
        The file that it was read from.
    tables : dict
        Its tables as written, presets and overrides included.
    sweep : dict, optional
        Its table ``[sweep]``, as written.
    own : tuple of str
        The tables that it has itself, overrides included, and not from a preset.
    """

    name: str
    origin: str
    config: Tables
    path: Path | None = None
    tables: Mapping[str, Any] = field(default_factory=dict)
    sweep: Mapping[str, Any] | None = None
    own: tuple[str, ...] = ()


@dataclass(frozen=True)
class Reader:
    """What reads studies of a kind.

    Parameters
    ----------
    kind : type
        The class of resolved studies.
    shipped : Traversable
        The folder of those that ship with the package.
    """

    kind: type[Tables]
    shipped: Traversable

    def _left(
        self, table: str, below: Mapping[str, Any], over: Mapping[str, Any]
    ) -> Mapping[str, Any]:
        """Return what is left of a table under one that may name another card, law or model."""
        for part in self.kind.known:
            if table in part.renew:
                left: Mapping[str, Any] = named(part.renew[table])(below, over)
                return left
        return below

    def names(self) -> list[str]:
        """Return the names of the studies that ship with the package."""
        shipped = self.shipped.iterdir()
        return sorted(entry.name.removesuffix(".toml") for entry in shipped if entry.is_file())

    def load(
        self,
        study: str | Mapping[str, Any],
        overrides: Sequence[str] | Mapping[str, Any] = (),
        over: Sequence[str] | Mapping[str, Any] = (),
    ) -> Study:
        """Return a study, resolved and checked.

        Parameters
        ----------
        study : str or mapping
            The path of a TOML file, or the name of a shipped study; or its tables, or keys as in
            ``{"preset": "paper", "flow.gap": "3.5 mm"}``.
        overrides : sequence of str, or mapping
            ``"flow.gap=3.5 mm"`` and the like, or as ``study``; they win over the file, and the
            file over its preset.
        over : sequence of str, or mapping
            What varies besides or instead: ``"flow.gap=2.5 mm, 3 mm"`` is an entry of
            ``[sweep]``, and so is each of a mapping.

        Raises
        ------
        ConfigError
            If there is no such study, it is not TOML, or a parameter is wrong; one line for each
            fault, that names the key, the value, the bound and the way out.
        """
        file: Path | None = None
        if isinstance(study, Mapping):
            name, tables, origin = IN_PYTHON, read_tables(study), "tables in Python"
        else:
            path = Path(study)
            file = path if self._is_study_file(path, study) else None
            name, tables = (path.stem, read_toml(path)) if file else (study, self._preset(study))
            origin = path.name if file else f"preset {name}"
        tables = self._said(tables)
        if isinstance(overrides, Mapping):
            overriding = read_tables(overrides)
            overrides = [f"{key}={excerpt(value)}" for key, value in overrides.items()]
        else:
            overriding = read_overrides(overrides)
        tables = self.merged(tables, overriding)
        is_preset = file is None and not isinstance(study, Mapping)
        own = tuple(overriding if is_preset else tables)
        if (preset := tables.pop("preset", None)) is not None:
            if not isinstance(preset, str):
                shown = excerpt(preset)
                msg = f'preset = {shown}: must be the name of a shipped study, such as "paper"'
                raise ConfigError(msg)
            tables = self.merged(self._lent(preset), tables)
            origin += f", preset {preset}"
        if overrides:
            origin += ", with " + ", ".join(overrides)
        sweep = tables.pop("sweep", None)
        if sweep is not None and not isinstance(sweep, Mapping):
            msg = f"sweep = {excerpt(sweep)}: is a table of what varies: write [sweep]"
            raise ConfigError(msg)
        if isinstance(over, Mapping):
            varying: dict[str, Any] = {key: plain(entry) for key, entry in over.items()}
            over = list(varying)
        else:
            varying = read_varying(over)
        if varying:
            sweep = {**(sweep or {}), **varying}
            origin += ", over " + " and ".join(over)
        refuse_without_effect(overriding, sweep or {}, varying, self._lent_by(sweep or {}, tables))
        return Study(
            name=name,
            origin=legible(origin, len(origin)),
            config=self.resolve(tables),
            path=file if file and file.is_file() else None,
            tables=tables,
            sweep=sweep,
            own=own,
        )

    def replaces_another(self, folder: Path, config: Tables) -> bool:
        """Tell whether a results folder shows a run of other parameters than a study's.

        Parameters
        ----------
        folder : Path
            The results folder; it need not be there. One whose config.toml cannot be read shows
            nothing that could be told apart: whether it may be used is for the store to say.
        config : Tables
            The study that is to run into it.
        """
        try:
            return self.resolve(read_toml(folder / "config.toml")) != config
        except ConfigError:
            return False

    def resolve(self, tables: Mapping[str, Any]) -> Tables:
        """Return the resolved study of nested tables such as TOML gives.

        Raises
        ------
        ConfigError
            One line for each fault.
        """
        try:
            return self.kind.model_validate(dict(tables))
        except ValidationError as error:
            lent = {k: v for k, v in self.kind.lent(tables).items() if not _has(tables, k)}
            told = {key: replace(one, value=_rounded(one.value)) for key, one in lent.items()}
            whole, follows = filled(tables, told), {key: one.by for key, one in lent.items()}
            raise ConfigError(explain(error, whole, self.kind, follows)) from None

    def _is_study_file(self, path: Path, study: str) -> bool:
        """Tell a file from a shipped study, which wins over a folder of its name."""
        shown = legible(study, _LONGEST_PATH)
        try:
            is_folder = path.is_dir()
            # A pipe is read like a file: /dev/stdin, or what a shell writes for <(...).
            if path.exists() and not is_folder:
                return True
        except OSError as error:
            msg = f"{shown}: no such study file: {(error.strerror or str(error)).lower()}"
            raise ConfigError(msg) from error
        shipped = self.names()
        if study in shipped:
            return False
        if is_folder:
            inside = path / ("config.toml" if (path / "config.toml").is_file() else "study.toml")
            example = legible(str(inside), _LONGEST_PATH)
            msg = f"{shown}: is a folder, not a study file: name a file in it, such as {example}"
            raise ConfigError(msg)
        if path.suffix == ".toml" or len(path.parts) > 1:
            msg = f"{shown}: no such study file; the shipped studies are: {', '.join(shipped)}"
            raise ConfigError(msg)
        return False

    def _preset(self, name: str) -> dict[str, Any]:
        known = self.names()
        if name not in known:
            nearest = get_close_matches(name, known, n=1)
            guess = f"; did you mean {nearest[0]}?" if nearest else ""
            shipped = ", ".join(known)
            msg = (
                f'no study is called "{legible(name)}"{guess} '
                f"(shipped: {shipped}; or a path to a TOML file)"
            )
            raise ConfigError(msg)
        source = self.shipped.joinpath(f"{name}.toml")
        return parse_toml(source.read_text(encoding="utf-8"), f"preset {name}")

    def _lent(self, name: str) -> dict[str, Any]:
        """Return the parameters of a shipped study, those that it has from another included.

        Its table ``[sweep]`` is not lent: a study that says of nothing that it varies is one study.
        """
        tables = self._preset(name)
        base = tables.pop("preset", None)
        tables.pop("sweep", None)
        return self.merged(self._lent(base), tables) if base else tables

    def merged(self, base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
        """Return ``base`` with the keys of ``over``, table by table.

        Another card, law or model begins anew: `Part.renew`. What parts lend by a key of ``over``
        takes the place of what ``base`` said: `Part.lend`.
        """
        return self.renewed(self._laid(base, over), over)

    def renewed(self, both: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
        """Return tables without what parts lend by keys that ``over``, in them, says itself."""
        left = dict(both)
        for key, one in self.kind.lent(both).items():
            if any(_has(over, by) for by in one.by) and not _has(over, key):
                left = _without(left, key)
        return left

    def _lent_by(
        self, sweep: Mapping[str, Any], tables: Mapping[str, Any]
    ) -> dict[str, tuple[str, ...]]:
        """Return the keys that follow from others, those that a sweep varies among them."""
        whole = dict(tables)
        examples = {item.key: item.example for item in declarations(self.kind)}
        for key in varied(sweep):
            if key in examples:
                table, _, name = key.partition(".")
                whole = self._laid(whole, {table: {name: examples[key]}})
        return {key: one.by for key, one in self.kind.lent(whole).items()}

    def _said(self, tables: Mapping[str, Any]) -> dict[str, Any]:
        """Return a file's tables without what they lend to themselves: a resolved copy has both.

        So whatever is laid over a copy does what it does over the study that it is a copy of.
        """
        said = dict(tables)
        for key, one in self.kind.lent(tables).items():
            if _has(tables, key) and _at(tables, key) == one.value:
                said = _without(said, key)
        return said

    def _laid(self, base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
        both = dict(base)
        for key, value in over.items():
            below = both.get(key)
            if isinstance(below, Mapping) and isinstance(value, Mapping):
                left = self._left(key, below, value)
                both[key] = self._laid(left, value)
            else:
                both[key] = value
        return both


def _has(tables: Mapping[str, Any], key: str) -> bool:
    """Tell whether tables as written say a key such as ``flow.gap``."""
    table, _, name = key.partition(".")
    own = tables.get(table)
    return isinstance(own, Mapping) and own.get(name) is not None


def _at(tables: Mapping[str, Any], key: str) -> object:
    table, _, name = key.partition(".")
    return tables[table][name]


def _without(tables: Mapping[str, Any], key: str) -> dict[str, Any]:
    """Return tables without a key; a table that it was alone in stays."""
    table, _, name = key.partition(".")
    own = tables.get(table)
    if not isinstance(own, Mapping):
        return dict(tables)
    return {**tables, table: {one: value for one, value in own.items() if one != name}}


def _rounded(value: float) -> float:
    """Return a number that nobody wrote with the digits that a person would."""
    return float(f"{value:.6g}")
