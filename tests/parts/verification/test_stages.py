"""The stored ladder: what its stage keeps, what the summary and the words make of it."""

import json
import math

import pytest

from fibermelt.engine.netcdf import from_bytes, to_bytes
from fibermelt.engine.stages import Parameters
from fibermelt.errors import ConvergenceError
from fibermelt.parts.verification.stages import verification_stage
from fibermelt.parts.verification.summary import summarize_verification, verification_in_words
from fibermelt.study.chain import CHAIN
from fibermelt.verify import Rung, as_dataset_rows, below, climb, order, rungs
from fibermelt.verify.words import as_answer

ERROR = below("an error", "This with that.", "a book", 1e-3, "a tenth of it", "Pa")
ORDER = order("an order", "This with that.", "a book", (1.9, 2.1), "theory has 2")
OTHER = below("another", "This with that.", "a book", 1.0, "half of it")


def refuse():
    msg = "no answer after 8 steps"
    raise ConvergenceError(msg)


FIRST = Rung("flow", (ERROR,), lambda: (5e-4,), quick=True, brief=True)
SECOND = Rung("fiber", (ORDER,), refuse, quick=True)
THIRD = Rung("voids", (OTHER,), lambda: (2.0,), quick=False)


@pytest.fixture
def ladder(monkeypatch):
    monkeypatch.setattr(rungs, "LADDER", (FIRST, SECOND, THIRD))


def stored(extent, told=None):
    say = (lambda line: None) if told is None else told.append
    dataset = verification_stage(Parameters({"study.ladder": extent}), {}, say)
    return from_bytes(to_bytes(dataset))


@pytest.mark.parametrize(("extent", "count"), [("brief", 1), ("quick", 2), ("full", 3)])
def test_the_study_says_how_much(ladder, extent, count):
    told = []
    results = stored(extent, told)
    assert results.sizes == {"check": count}
    assert results["check_ladder"].item() == extent
    assert told == ["flow: an error", "fiber: an order", "voids: another"][:count]
    assert "ngsolve" in results["check_software"].item()


def test_every_column_is_kept(ladder):
    results = stored("full")
    columns = as_dataset_rows(climb(rungs.LADDER))
    assert {f"check_{key}" for key in columns} == {
        name for name in results.variables if results[name].ndim
    }
    for key, values in columns.items():
        if key != "seconds":
            kept = results[f"check_{key}"].to_numpy().tolist()
            assert str(kept) == str(values), key  # as words, in which NaN is NaN


def test_the_summary_says_what_the_command_does(ladder):
    found = summarize_verification(stored("full"))["verification"]
    answer = as_answer(climb(rungs.LADDER))
    assert (found["passed"], found["failed"]) == (1, 2) == (answer["passed"], answer["failed"])
    for ours, theirs in zip(found["checks"], answer["checks"], strict=True):
        assert {**ours, "seconds": 0.0} == {**theirs, "seconds": 0.0}
    assert found["checks"][1]["value"] is None
    assert found["checks"][1]["failure"] == "no answer after 8 steps"
    json.dumps(found, allow_nan=False)


def test_words(ladder):
    passed, failed = (
        verification_in_words(summarize_verification(stored(extent)))
        for extent in ("brief", "full")
    )
    assert passed == ["verification    1 of 1 checks pass (brief ladder)"]
    assert failed[0] == "verification    1 of 3 checks pass (full ladder)"
    assert "FAILED: an order and 1 more" in failed[1]


def test_a_check_without_a_number_has_none_in_the_store(ladder):
    results = stored("quick")
    assert math.isnan(results["check_value"].to_numpy()[1])
    assert results["check_passed"].to_numpy().tolist() == [True, False]


def test_the_part_needs_nothing_else():
    part = next(part for part in CHAIN.parts if part.name == "verification")
    assert [stage.name for stage in CHAIN.needed([part.name], {})] == ["verification"]
