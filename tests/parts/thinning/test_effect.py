"""What thinning does, in summary, words, figure and table, of numbers that are easily followed."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr
from drawn_cases import INDICES, MODELS, effects

from fibermelt.errors import ConfigError
from fibermelt.parts.thinning.figures import figure_thinning
from fibermelt.parts.thinning.part import PART
from fibermelt.parts.thinning.section import thinning
from fibermelt.parts.thinning.stages import CAUSES
from fibermelt.parts.thinning.summary import summarize_thinning, thinning_in_words
from fibermelt.study.loading import resolve
from fibermelt.voids import ATMOSPHERE


@pytest.fixture
def results() -> xr.Dataset:
    return effects()


def test_only_streamlines_that_are_regular_in_every_flow_count(results: xr.Dataset) -> None:
    laws = summarize_thinning(results)["thinning"]
    assert json.loads(json.dumps(laws, allow_nan=False)) == laws
    assert [law["index"] for law in laws] == INDICES
    first = laws[0]["confined-ellipse"]
    assert first["both"] == {
        "lowest": ATMOSPHERE - 1e5,
        "deepest": ATMOSPHERE - 1e5,
        "bound": ATMOSPHERE - 2e5,
    }
    assert first["flow"]["lowest"] == ATMOSPHERE - 3e5
    assert (first["period"], first["stall_angle"]) == (None, 0.1)
    none = summarize_thinning(results.assign(effect_regular=("streamline", np.zeros(2))))
    assert none["thinning"][0]["spheroid"]["both"]["lowest"] is None


def test_terminal_and_page_tell_the_same(results: xr.Dataset) -> None:
    summary = summarize_thinning(results)
    lines = thinning_in_words(summary)
    told = next(line for line in lines if "ellipse: lowest" in line).split()[-3:]
    assert told == ["0.001", "-1.199", "-2.399"]
    page = str(thinning.words(results, summary))
    for number in ("−1.199", "−2.399", "stalls"):
        assert number in page.replace("-", "−")


def test_the_figure_has_a_curve_for_each_cause_and_model(results: xr.Dataset) -> None:
    figure = figure_thinning.draw(results)
    local, peak, flow = figure.axes
    curves = [line for line in local.lines if len(line.get_xdata()) == len(INDICES)]
    assert len(curves) == len(CAUSES) * len(MODELS)
    assert len(peak.lines) == len(MODELS)
    assert len(flow.lines) == 1
    words = figure_thinning.words(results)
    assert "1 of 2 streamlines" in words.caption
    alone = results.sel(effect_model=["confined-ellipse"])
    assert len(figure_thinning.draw(alone).axes[1].lines) == 1


@pytest.mark.parametrize("indices", [[], [0.5, 0.7], [0.5, 0.5], [1.0], [0.2]])
def test_indices_that_do_not_fall_are_refused(indices: list[float]) -> None:
    with pytest.raises(ConfigError, match=r"thinning\.indices"):
        resolve({"thinning": {"indices": indices}})


def test_the_stage_declares_what_the_flow_needs() -> None:
    assert {"flow", "law", "numerics.flow_order"} <= set(PART.brings[0].parameters)
