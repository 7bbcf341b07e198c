"""Voids of a finished run at another moisture, temperature or material: `fibermelt voids`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.engine.finished import finished_results, read_finished
from fibermelt.engine.results import study_of
from fibermelt.engine.stages import Parameters
from fibermelt.errors import ConfigError, StoreError
from fibermelt.parts.melt.cards import Card, load_card
from fibermelt.parts.melt.config import Melt
from fibermelt.parts.melt.melt import SAME_TEMPERATURE, viscosity_of
from fibermelt.parts.voids.answer import answered, by_layer
from fibermelt.parts.voids.bubbles import nuclei_of
from fibermelt.parts.voids.config import Voids
from fibermelt.parts.voids.melt import FROM_CARD, moist_melt
from fibermelt.parts.voids.part import with_orientation
from fibermelt.parts.voids.stages import assess_bead
from fibermelt.parts.voids.summary import BESIDE, summarize_voids
from fibermelt.study.loading import resolve

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["VoidQuestion", "answer_voids", "held_against"]

STAGES = ("streamlines", "cell", "motion")
"""Whose data the results of a bead hold together."""

ASKED = {name: f"--{name}" for name in ("material", "moisture", "temperature")}
"""What the three are called on the command line."""


@dataclass(frozen=True)
class VoidQuestion:
    """What `fibermelt voids` asks of a finished run; None is as the study has it.

    Parameters
    ----------
    material : str, optional
        Name or path of a material card. With another card than the study's, moisture and
        temperature that are not given are those of the card.
    moisture : float, optional
        Over the mass of polymer [-].
    temperature : float, optional
        Of the melt [K].
    """

    material: str | None = None
    moisture: float | None = None
    temperature: float | None = None


def answer_voids(directory: Path, question: VoidQuestion) -> dict[str, Any]:
    """Return where in the bead of a finished run voids can start; nothing in it is changed.

    Parameters
    ----------
    directory : Path
        Its results folder.
    question : VoidQuestion
        What is asked.

    Returns
    -------
    dict
        The ``"voids"`` of `fibermelt.parts.voids.summary.summarize_voids`; with ``"held"``, a
        sentence, where material or temperature are not those of the run, whose pressures stay.

    Raises
    ------
    StoreError
        If there is no finished run of a bead, or it is damaged.
    ConfigError
        If there is no such card, or a value is out of its range.
    """
    results = finished_results(directory)
    if "bound_lowest" not in results:
        msg = (
            f'{directory}: the run has no fibers in a bead: name "bead" or "voids" in study.parts '
            "and run it again"
        )
        raise StoreError(msg)
    study = resolve(study_of(results))
    table, usual = study.table(Melt), study.table(Voids)
    card = table.card if question.material is None else _other(question.material)
    is_other = card.key != table.card.key
    given = FROM_CARD if is_other else usual.moisture
    temperature = question.temperature
    if temperature is None:
        temperature = card.temperature if is_other else table.temperature
    melt = moist_melt(
        card,
        given if question.moisture is None else question.moisture,
        temperature,
        usual.threshold_rate,
        density=None if is_other else table.density,
        keys=ASKED,
    )
    fed = STAGES + with_orientation({"study.parts": study.study.parts})
    values = Parameters(study.values())
    found = assess_bead(
        dict.fromkeys(fed, results), viscosity_of(values), melt, usual.layers, nuclei_of(values)
    )
    answer = _summary(found, results)
    is_as_run = math.isclose(melt.temperature, table.temperature or 0.0, rel_tol=SAME_TEMPERATURE)
    if is_other or not is_as_run:
        answer["held"] = (
            f"the local pressures, those of the run's melt, {table.card.name} at "
            f"{table.temperature:g} K; for those of another, run the study with its melt.material "
            "and melt.temperature"
        )
    return answer


def held_against(voids: Mapping[str, Any], other: Path) -> dict[str, Any]:
    """Return what is said of a run's voids, told beside another finished run.

    Parameters
    ----------
    voids : mapping
        The ``"voids"`` of a summary.
    other : Path
        The results folder of the other.

    Raises
    ------
    StoreError
        If that holds no finished run with voids.
    """
    beside = read_finished(other).summary.get("voids")
    if beside is None:
        msg = f'{other}: the run has no voids: name "voids" in study.parts and run it again'
        raise StoreError(msg)
    layers = [one["severity"] for one in beside["profile"]]
    found = {**voids, "against": {"name": other.name, **beside["severity"], "profile": layers}}
    found["against"]["layers"] = by_layer(found)
    return {**found, "answer": answered(found)}


def _other(material: str) -> Card:
    try:
        return load_card(material)
    except ConfigError as error:
        msg = "\n".join(f"--material: {line}" for line in str(error).split("\n"))
        raise ConfigError(msg) from error


def _summary(found: xr.Dataset, results: xr.Dataset) -> dict[str, Any]:
    named = {name: results[name] for name in BESIDE if name in results}
    voids: dict[str, Any] = summarize_voids(found.assign(named))["voids"]
    return voids
