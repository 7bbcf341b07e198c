"""The ladder itself: what passes, what fails, what is recorded; nothing goes unexplained."""

import json
import math
from dataclasses import asdict

import numpy as np
import pytest

from fibermelt.engine.files import canonical, digest
from fibermelt.errors import ConvergenceError
from fibermelt.verify import (
    LADDER_VERSION,
    Check,
    Rung,
    as_dataset_rows,
    below,
    chosen,
    climb,
    order,
)
from fibermelt.verify.averages import balances, circle_rule, sphere_rule
from fibermelt.verify.rungs import LADDER
from fibermelt.verify.words import as_answer, in_words

ERROR = below("an error", "This with that.", "a book", 1e-3, "a tenth of it", "Pa")
ORDER = order("an order", "This with that.", "a book", (1.9, 2.1), "theory has 2")


def rung(*values: float, expected=(ERROR,), quick: bool = True) -> Rung:
    return Rung("fiber", tuple(expected), lambda: values, quick)


def only(checks: tuple[Check, ...]) -> Check:
    (check,) = checks
    return check


def refuse() -> tuple[float]:
    msg = "no answer after 8 steps:\nuse a finer mesh"
    raise ConvergenceError(msg)


@pytest.mark.parametrize(
    ("expected", "value", "passes"),
    [
        (ERROR, 0.0, True),
        (ERROR, 1e-3, True),
        (ERROR, 1.001e-3, False),
        (ERROR, -1e-9, False),  # no error is negative: the measurement is wrong
        (ERROR, math.nan, False),
        (ERROR, math.inf, False),
        (ORDER, 2.0, True),
        (ORDER, 1.89, False),
        (ORDER, 2.11, False),
        (ORDER, math.nan, False),
    ],
)
def test_a_wrong_number_fails(expected, value, passes) -> None:
    check = only(climb([rung(value, expected=[expected])]))
    assert check.passed is passes
    assert (check.name, check.subject, check.failure) == (expected.name, "fiber", "")


def test_a_check_that_raises_is_recorded_and_the_rest_goes_on() -> None:
    broken = Rung("flow", (ERROR, ORDER), refuse, quick=True)
    first, second, last = climb([broken, rung(0.0)])
    for check in (first, second):
        assert not check.passed
        assert math.isnan(check.value)
        assert check.failure == r"no answer after 8 steps:\nuse a finer mesh"
    assert last.passed
    assert [check.name for check in (first, second)] == ["an error", "an order"]


def test_a_mistake_in_a_check_is_not_taken_for_a_result() -> None:
    with pytest.raises(ValueError, match="zip"):
        climb([rung(1.0, 2.0)])
    with pytest.raises(ZeroDivisionError):
        climb([Rung("flow", (ERROR,), lambda: (1.0 / 0,), quick=True)])


def test_quick_leaves_out_what_is_not_and_every_rung_is_announced() -> None:
    told: list[tuple[str, str]] = []
    rungs = [rung(0.0), rung(2.0, expected=[ORDER], quick=False)]
    assert len(climb(rungs, say=lambda *words: told.append(words))) == 2
    assert told == [("fiber", "an error"), ("fiber", "an order")]
    assert only(climb(rungs, quick=True)).name == "an error"


def test_columns_and_json() -> None:
    checks = climb([rung(5e-4), Rung("flow", (ORDER,), refuse, quick=True)])
    columns = as_dataset_rows(checks)
    assert {len(column) for column in columns.values()} == {2}
    assert columns["passed"] == [True, False]
    assert columns["value"][0] == 5e-4
    answer = json.loads(json.dumps(as_answer(checks), allow_nan=False))
    assert list(answer) == ["checks", "passed", "failed", "software"]
    assert (answer["passed"], answer["failed"]) == (1, 1)
    good, bad = answer["checks"]
    assert list(good) == list(columns)
    assert (good["value"], good["highest"], good["unit"]) == (5e-4, 1e-3, "Pa")
    assert (bad["value"], bad["passed"], bad["subject"]) == (None, False, "flow")
    assert set(answer["software"]) == {"python", "fibermelt", "ngsolve", "numpy", "scipy"}


def test_words_say_what_failed_and_why() -> None:
    words = in_words(climb([rung(5e-4), rung(1.0), Rung("flow", (ORDER,), refuse, quick=True)]))
    table, *failures = words.split("\n\n")
    assert [line.split()[0] for line in table.splitlines()[1:]] == ["pass", "FAIL", "FAIL"]
    assert "5.0e-04 Pa" in table
    assert "1.9 to 2.1" in table
    assert "the bound: a tenth of it" in failures[0]
    assert "no answer after 8 steps" in failures[1]
    assert failures[-1].startswith("1 of 3 checks pass in ")


def test_everything_in_the_ladder_is_explained() -> None:
    expected = [one for rung in LADDER for one in rung.expected]
    names = [one.name for one in expected]
    assert len(set(names)) == len(names)
    for one in expected:
        assert one.reference, one.name
        assert one.because, one.name
        assert one.what.endswith("."), one.name
        assert one.lowest < one.highest, one.name
        assert math.isfinite(one.highest), one.name
        assert one.lowest == 0.0 or one.kind == "order within band", one.name
    for extent in ("brief", "quick", "full"):
        subjects = {rung.subject for rung in chosen(LADDER, extent)}
        assert subjects == {"flow", "fiber", "melt", "orientation", "voids"}, extent
    assert set(chosen(LADDER, "brief")) < set(chosen(LADDER, "quick")) < set(LADDER)


DECLARED = (5, "0733783c8ee75b06")
"""The version of the ladder, and the digest of what it declares."""


def test_a_ladder_that_declares_something_else_has_another_version() -> None:
    """If this fails: raise LADDER_VERSION, so that no stored check is kept, and state both here."""
    declared = [
        [rung.subject, rung.quick, rung.brief, *(asdict(one) for one in rung.expected)]
        for rung in LADDER
    ]
    assert (LADDER_VERSION, digest(canonical(declared))[:16]) == DECLARED


@pytest.mark.parametrize(("d", "rule"), [(2, circle_rule(64)), (3, sphere_rule(16))])
def test_balances_see_what_is_wrong(d: int, rule) -> None:
    """A point force's flow keeps all balances; each is lost by what should lose it, by as much."""
    axis = np.eye(d)[0]

    def stokeslet(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        r = np.linalg.norm(x, axis=-1, keepdims=True)
        along = x @ axis
        if d == 2:
            return -np.log(r) * axis + along[..., None] * x / r**2, 2.0 * along / r[..., 0] ** 2
        return axis / r + along[..., None] * x / r**3, 2.0 * along / r[..., 0] ** 3

    points = 2.0 * np.vstack([np.eye(d), np.full(d, 0.7)])
    rho = np.full(len(points), 0.3)
    good = balances(stokeslet, points, rho, rule)
    assert max(good.mass, good.momentum, good.harmonic) < 1e-12  # rounding over rho^2

    def leaking(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        u, p = stokeslet(x)
        return u + 1e-3 * x, p

    def pushed(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        u, p = stokeslet(x)
        return u, 1.01 * p

    assert balances(leaking, points, rho, rule).mass > 1e-4
    assert balances(pushed, points, rho, rule).momentum == pytest.approx(0.01 / 1.01, rel=0.02)
    bent = balances(lambda x: (stokeslet(x)[0], np.sum(x * x, axis=-1)), points, rho, rule)
    assert bent.harmonic > 1e-3
