"""From what a person wrote to a resolved study: presets, files, overrides, and what is wrong."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fibermelt.errors import ConfigError
from fibermelt.study.config import Config
from fibermelt.study.messages import explain

__all__ = ["Study", "load_study", "preset_names", "resolve"]


@dataclass(frozen=True)
class Study:
    """A study that can be run: its name, where it came from, and its resolved parameters."""

    name: str
    origin: str
    config: Config
    path: Path | None = None


def preset_names() -> list[str]:
    """Return the names of the studies that ship with the package."""
    shipped = files("fibermelt.study").joinpath("presets").iterdir()
    return sorted(entry.name.removesuffix(".toml") for entry in shipped if entry.is_file())


def load_study(study: str, overrides: Sequence[str] = ()) -> Study:
    """Return a study, resolved and checked.

    Parameters
    ----------
    study : str
        The path of a TOML file, or the name of a shipped study.
    overrides : sequence of str
        ``"flow.gap=3.5 mm"`` and the like; they win over the file, and the file over its preset.

    Raises
    ------
    ConfigError
        If there is no such study, it is not TOML, or a parameter is wrong; one line for each
        fault, that names the key, the value, the bound and the way out.
    """
    path = Path(study)
    if path.is_file():
        name, tables = path.stem, _read(path)
    elif path.suffix == ".toml" or len(path.parts) > 1:
        what = "is a folder, not a study file" if path.is_dir() else "no such study file"
        msg = f"{study}: {what}; the shipped studies are: {', '.join(preset_names())}"
        raise ConfigError(msg)
    else:
        name, tables = study, _preset(study)
    file = path if path.is_file() else None
    origin = path.name if file else f"preset {name}"
    tables = _merged(tables, _overriding(overrides))
    if (preset := tables.pop("preset", None)) is not None:
        if not isinstance(preset, str):
            msg = f'preset = {preset}: must be the name of a shipped study, such as "paper"'
            raise ConfigError(msg)
        tables = _merged(_preset(preset), tables)
        origin += f", preset {preset}"
    if overrides:
        origin += ", with " + ", ".join(overrides)
    return Study(name=name, origin=origin, config=resolve(tables), path=file)


def resolve(tables: Mapping[str, Any]) -> Config:
    """Return the resolved study of nested tables such as TOML gives.

    Raises
    ------
    ConfigError
        One line for each fault.
    """
    try:
        return Config.model_validate(dict(tables))
    except ValidationError as error:
        raise ConfigError(explain(error, tables)) from None


def _read(path: Path) -> dict[str, Any]:
    try:
        text = path.read_bytes().decode("utf-8")
    except OSError as error:
        msg = f"{path}: cannot be read: {error.strerror}"
        raise ConfigError(msg) from error
    except UnicodeDecodeError as error:
        msg = f"{path}: is not a TOML file: byte {error.start} is not UTF-8 text"
        raise ConfigError(msg) from error
    return _parsed(text, str(path))


def _parsed(text: str, where: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        msg = f"{where}: not TOML: {str(error)[:1].lower()}{str(error)[1:]}"
        raise ConfigError(msg) from None


def _preset(name: str) -> dict[str, Any]:
    known = preset_names()
    if name not in known:
        nearest = get_close_matches(name, known, n=1)
        guess = f"; did you mean {nearest[0]}?" if nearest else ""
        shipped = ", ".join(known)
        msg = f'no study is called "{name}"{guess} (shipped: {shipped}; or a path to a TOML file)'
        raise ConfigError(msg)
    source = files("fibermelt.study").joinpath("presets", f"{name}.toml")
    return _parsed(source.read_text(encoding="utf-8"), f"preset {name}")


def _merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``base`` with the keys of ``over``, table by table."""
    merged = dict(base)
    for key, value in over.items():
        below = merged.get(key)
        if isinstance(below, Mapping) and isinstance(value, Mapping):
            merged[key] = _merged(below, value)
        else:
            merged[key] = value
    return merged


def _overriding(overrides: Sequence[str]) -> dict[str, Any]:
    """Return the tables that ``flow.gap=3.5 mm`` stands for."""
    tables: dict[str, Any] = {}
    for override in overrides:
        key, equals, text = override.partition("=")
        path = [part.strip() for part in key.split(".")]
        if not equals or not all(path):
            msg = f'-s {override}: write it as key=value, such as -s flow.gap="3.5 mm"'
            raise ConfigError(msg)
        nested: Any = _override_value(text.strip())
        for part in reversed(path):
            nested = {part: nested}
        tables = _merged(tables, nested)
    return tables


def _override_value(text: str) -> object:
    """Return what TOML reads in ``text``, or else the text itself: shells eat quotes."""
    try:
        read = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    return read["value"] if set(read) == {"value"} else text
