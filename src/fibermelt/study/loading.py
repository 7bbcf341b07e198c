"""From what a person wrote to a resolved study: shipped studies, files, overrides."""

from __future__ import annotations

from importlib.resources import files

from fibermelt.engine.loading import Reader
from fibermelt.study.config import Config

__all__ = ["load_study", "merged", "preset_names", "renewed", "replaces_another", "resolve"]

_READER = Reader(Config, files("fibermelt.data").joinpath("studies"))

load_study = _READER.load
merged = _READER.merged
preset_names = _READER.names
renewed = _READER.renewed
replaces_another = _READER.replaces_another
resolve = _READER.resolve
