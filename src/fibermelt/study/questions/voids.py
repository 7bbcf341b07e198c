"""Voids of a finished run at another moisture, temperature or material: `fibermelt voids`."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fibermelt.errors import StoreError
from fibermelt.study.finished import finished_results
from fibermelt.study.materials import load_card, material_names
from fibermelt.study.variables import study_of
from fibermelt.study.voids.config import Voids
from fibermelt.study.voids.melt import FROM_CARD, MoistMelt, moist_melt
from fibermelt.study.voids.stages import assess_bead, with_orientation
from fibermelt.study.voids.summary import summarize_voids

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["VoidQuestion", "answer_voids"]

STAGES = ("streamlines", "cell", "motion")
"""Whose data the results of a bead hold together."""


SAME_TEMPERATURE = 1e-9
"""Part by which temperatures may differ and be one: 446 degF is 230 degC but for a rounding."""


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
        The ``"voids"`` of `fibermelt.study.voids.summary.summarize_voids`; with ``"held"``, a
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
    study = study_of(results)
    # A run of before there were voids has no such table.
    usual = Voids.model_validate(study.get("voids", {}))
    melt = _asked(question, usual)
    viscosity = study["melt"]["viscosity"]
    fed = STAGES + with_orientation({"study.parts": tuple(study["study"]["parts"])})
    found = assess_bead(dict.fromkeys(fed, results), viscosity, melt, usual.layers)
    answer = _summary(found, results)
    card, temperature = _of_study(usual)
    is_as_run = math.isclose(melt.temperature, temperature, rel_tol=SAME_TEMPERATURE)
    if melt.card.key != card or not is_as_run:
        answer["held"] = (
            f"the local pressures, those of the run's melt, melt.viscosity = {viscosity:g} Pa s; "
            "for those of the melt that is asked for, give its viscosity there: fibermelt run "
            f"{shlex.quote(str(directory / 'config.toml'))} --set melt.viscosity=..."
            f"{_settings(melt, card)} --out ..."
        )
    return answer


def _settings(melt: MoistMelt, card: str) -> str:
    """Return what a run needs besides its viscosity to be of a melt, on the command line.

    A study knows shipped cards only; pressures do not depend on the card, so that a run of the
    viscosity alone may be asked about any.
    """
    temperature = f' --set voids.temperature="{melt.temperature:g} K"'
    if melt.card.key == card:
        return temperature
    if melt.card.key not in material_names():
        return ""
    moisture = f" --set voids.moisture={melt.moisture:g}"
    return f"{temperature} --set voids.material={melt.card.key}{moisture}"


def _of_study(usual: Voids) -> tuple[str, float]:
    """Return the card and the temperature [K] of the study's melt."""
    card = load_card(usual.material)
    return card.key, card.temperature if usual.temperature == FROM_CARD else usual.temperature


def _asked(question: VoidQuestion, usual: Voids) -> MoistMelt:
    """Return the melt that is asked for."""
    other = question.material is not None and question.material != usual.material
    given = {
        name: getattr(question, name)
        for name in ("material", "moisture", "temperature")
        if getattr(question, name) is not None
    }
    rest: Mapping[str, Any] = {"moisture": FROM_CARD, "temperature": FROM_CARD}
    if not other:
        rest = {name: getattr(usual, name) for name in ("material", "moisture", "temperature")}
    return moist_melt(**{**rest, **given}, threshold_rate=usual.threshold_rate, said="--")


def _summary(found: xr.Dataset, results: xr.Dataset) -> dict[str, Any]:
    named = {name: results[name] for name in ("streamline", "near_singularity")}
    voids: dict[str, Any] = summarize_voids(found.assign(named))["voids"]
    return voids
