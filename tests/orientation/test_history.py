"""Orientation along histories against the exact solution, with the orders that theory says."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, ConvergenceError, HistoryError
from fibermelt.history import simple_shear
from fibermelt.orientation import evolve, orthotropic
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.evolve import follow_orientation
from fibermelt.orientation.flows import FLOWS
from fibermelt.orientation.models import (
    ARDRSC,
    IARD,
    RSC,
    FolgarTucker,
    Jeffery,
    OrientationModel,
    shape_factor,
)
from fibermelt.orientation.steady import steady_state
from fibermelt.orientation.tensors import isotropic
from fibermelt.verify.orientation import (
    DURATION,
    FACTOR,
    deformed_moment,
    fifth_order_errors,
    history_error,
    turning_gradient,
)

pytestmark = pytest.mark.verification

Array = NDArray[np.float64]

XI = FACTOR
EXACT = CLOSURES["exact"]


def test_jeffery_with_the_exact_closure_is_exact() -> None:
    """Fourth order in the spacing of the history's points, whose cubic is all that errs."""
    exact = deformed_moment()
    errors = [history_error(exact, points, 1e-11) for points in (21, 41, 81)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(orders - 3.85) < 0.2), orders  # 4, less what the ends' slopes lack
    assert errors[-1] < 5e-9


def test_what_is_exact_stays_in_range() -> None:
    time = np.linspace(0.0, DURATION, 21)
    path = (time, np.stack([turning_gradient(t) for t in time]))
    assert follow_orientation(Jeffery(XI), EXACT, path, isotropic()).violation == 0.0


def test_the_integrator_is_of_fifth_order() -> None:
    """A gradient that does not change is interpolated without error: one step to an interval."""
    points = (13, 25, 49)
    errors, steps = fifth_order_errors(points, 385)
    assert steps == [count - 1 for count in (*points, 385)]
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(np.abs(orders - 5.0) < 0.2), orders


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_the_error_is_below_its_estimate(tolerance: float) -> None:
    """The estimate is that of the lower order, so it is on the safe side; not by much more."""
    path = (np.array([0.0, 10.0]), np.stack([FLOWS["mixed"]] * 2))
    model = FolgarTucker(XI, 0.02)
    found = follow_orientation(model, CLOSURES["ORE"], path, isotropic(), rtol=tolerance)
    sharp = follow_orientation(model, CLOSURES["ORE"], path, isotropic(), rtol=1e-12, atol=1e-13)
    error = np.max(np.abs(found.a[-1] - sharp.a[-1]))
    assert error < found.error < 30.0 * tolerance
    assert found.trace_drift < 1e-13


def test_many_histories_and_tensors_at_once() -> None:
    """Each as if it were alone, within the tolerance of the steps."""
    model, closure = RSC(shape_factor(6.0), 0.0128, 0.2), CLOSURES["ORE"]
    time = np.array([np.linspace(0.0, end, 21) for end in (2.0, 5.0, 9.0)])
    L = np.zeros((3, 21, 2, 2))
    L[..., 0, 1] = 1.0 + 0.3 * np.sin(time)
    L[..., 0, 0] = 0.2 * np.cos(time)
    L[..., 1, 1] = -L[..., 0, 0]
    starts = np.stack([np.diag([0.5, 0.3, 0.2]), np.diag([0.2, 0.2, 0.6])])[:, None]
    found = follow_orientation(model, closure, (time, L), starts, rtol=1e-9, atol=1e-11)
    assert found.a.shape == (2, 3, 21, 3, 3)
    assert found.error.shape == found.violation.shape == (2, 3)
    for i in range(2):
        for j in range(3):
            one = follow_orientation(
                model, closure, (time[j], L[j]), starts[i, 0], rtol=1e-9, atol=1e-11
            )
            assert np.max(np.abs(found.a[i, j] - one.a)) < 1e-7


def test_between_uneven_points_a_quadratic_gradient_is_met_exactly() -> None:
    def path(time: Array) -> tuple[Array, Array]:
        shape = (1.0 + 0.8 * time - 0.3 * time**2)[:, None, None]
        return time, shape * FLOWS["mixed"] + time[:, None, None] * FLOWS["biaxial"]

    uneven = np.array([0.0, 0.1, 0.7, 0.9, 2.0, 2.2, 3.0])
    ends = [
        follow_orientation(
            FolgarTucker(XI, 0.02), CLOSURES["ORE"], path(time), isotropic(), rtol=1e-9
        ).a[-1]
        for time in (uneven, np.linspace(0.0, 3.0, 61))
    ]
    assert np.max(np.abs(ends[1] - ends[0])) < 1e-8  # ten times the tolerance of a step


def test_a_history_of_the_flow_is_a_path() -> None:
    found = follow_orientation(
        FolgarTucker(XI, 0.01), CLOSURES["ORE"], simple_shear(2.0, 3.0, 31), isotropic()
    )
    time = np.linspace(0.0, 6.0, 31)
    path = (time, np.broadcast_to(FLOWS["simple-shear"], (31, 3, 3)))
    same = follow_orientation(FolgarTucker(XI, 0.01), CLOSURES["ORE"], path, isotropic())
    assert np.max(np.abs(found.a - same.a)) < 1e-13  # strain is all that counts


def test_leaving_the_range_is_reported_not_clipped() -> None:
    path = (np.linspace(0.0, 8.0, 41), np.broadcast_to(FLOWS["planar"], (41, 3, 3)))
    found = follow_orientation(FolgarTucker(XI, 0.003), CLOSURES["linear"], path, isotropic())
    values = np.linalg.eigvalsh(found.a)
    assert found.violation > 0.05
    assert found.violation == pytest.approx(max(-np.min(values), np.max(values) - 1.0), abs=1e-12)


def test_what_no_history_can_have_is_refused() -> None:
    model, closure, a = FolgarTucker(XI, 0.01), CLOSURES["ORE"], isotropic()
    time, L = np.linspace(0.0, 1.0, 5), np.broadcast_to(FLOWS["planar"], (5, 3, 3))
    with pytest.raises(HistoryError, match="increase strictly"):
        follow_orientation(model, closure, (time[::-1], L), a)
    with pytest.raises(HistoryError, match="expected"):
        follow_orientation(model, closure, (time[:4], L), a)
    with pytest.raises(HistoryError, match="trace"):
        follow_orientation(model, closure, (time, L + np.eye(3)), a)
    with pytest.raises(ConfigError, match="a0 has trace"):
        follow_orientation(model, closure, (time, L), 2.0 * a)
    with pytest.raises(ConfigError, match="rtol = 0"):
        follow_orientation(model, closure, (time, L), a, rtol=0.0)
    with pytest.raises(ConfigError, match="leading axes"):
        follow_orientation(model, closure, (np.stack([time] * 2), np.stack([L] * 2)), [a] * 3)


def test_a_rate_that_cannot_be_followed_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a fit changes by its error over a small gap steps are short, here for ever."""
    monkeypatch.setattr(evolve, "MOST_STEPS", 400)
    path = (np.array([0.0, 5e3]), np.stack([FLOWS["planar"]] * 2))
    with pytest.raises(ConvergenceError, match=r"closure ORF: the interval from t = 0 s .* 400:"):
        follow_orientation(FolgarTucker(XI, 1e-3), CLOSURES["ORF"], path, isotropic())


ALIGNED = {
    "jeffery": Jeffery(0.997),
    "folgar-tucker": FolgarTucker(0.997, 0.01),
    "rsc": RSC(0.997, 0.01, 0.1),
    "ard-rsc": ARDRSC(0.997, 3.84e-4, -1.806e-3, 5.25e-2, 1.168e-5, -5e-4, kappa=1 / 30),
}


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("closure", ["ORF", "ORL", "ORW", "ORW3", "ORE"])
@pytest.mark.parametrize("model", ALIGNED.values(), ids=ALIGNED)
def test_fibers_may_enter_aligned(model: OrientationModel, closure: str, axis: int) -> None:
    """Two eigenvalues are zero; a fit that jumps there may keep them together."""
    path = (np.array([0.0, 0.5]), np.stack([FLOWS["simple-shear"]] * 2))
    start = np.diag(np.eye(3)[axis])
    found = follow_orientation(model, CLOSURES[closure], path, start)
    # Most of `ALIGNED` take some 30, the stiffest 330: explicit steps of 3 over the rate inside.
    assert found.steps + found.rejected < 400
    smooth = follow_orientation(model, CLOSURES["IBOF"], path, start)
    assert np.max(np.abs(found.a - smooth.a)) < 0.02  # as closures differ


@pytest.mark.parametrize(
    ("model", "closure", "axis"),
    [
        (ALIGNED["rsc"], "ORL", 1),
        (ALIGNED["jeffery"], "ORF", 1),
        (ALIGNED["jeffery"], "ORL", 2),  # the axes of the pair turn with the melt
        (ALIGNED["folgar-tucker"], "ORL", 1),
    ],
)
def test_what_slides_along_a_jump_is_its_limit(
    monkeypatch: pytest.MonkeyPatch, model: OrientationModel, closure: str, axis: int
) -> None:
    """Against the fit as published, which jumps, at a tolerance that steps over its jump."""
    path = (np.array([0.0, 0.5]), np.stack([FLOWS["simple-shear"]] * 2))
    start = np.diag(np.eye(3)[axis])
    found = follow_orientation(model, CLOSURES[closure], path, start)
    monkeypatch.setattr(orthotropic, "WIDTH", 0.0)
    published = follow_orientation(model, CLOSURES[closure], path, start, rtol=1e-5, atol=1e-7)
    # followed to first order of the steps only: a quarter of the fits' own error there, 2e-3
    assert np.max(np.abs(found.a - published.a)) < 5e-4
    errors = []
    for width in (1e-4, 3e-5):
        monkeypatch.setattr(orthotropic, "WIDTH", width)
        wider = follow_orientation(model, CLOSURES[closure], path, start)
        errors.append(np.max(np.abs(wider.a - found.a)))
    assert errors[1] < errors[0] < 5e-4


@pytest.mark.parametrize(
    ("model", "flow", "said"),
    [
        (lambda: ARDRSC(XI, -1.0), "simple-shear", "b1 = -1 must not be negative"),
        (lambda: ARDRSC(XI, 0.01, b5=-0.1), "simple-shear", r"diffusion is -0\.015 "),
        (lambda: ARDRSC(XI, 0.01, b4=0.1), "simple-shear", r"diffusion is -0\.04 "),
        (lambda: IARD(XI, 0.01, 0.9), "uniaxial", r"diffusion is -0\.002 .*at most 3/4"),
    ],
)
def test_diffusion_that_takes_fibers_from_where_none_are(
    model: Callable[[], OrientationModel], flow: str, said: str
) -> None:
    path = (np.array([0.0, 0.1]), np.stack([FLOWS[flow]] * 2))
    with pytest.raises(ConfigError, match=said):
        follow_orientation(model(), CLOSURES["ORE"], path, isotropic())
    with pytest.raises(ConfigError, match=said):
        steady_state(model(), FLOWS[flow], CLOSURES["ORE"])


def test_diffusion_that_is_negative_along_fibers_only() -> None:
    """What is emptied is filled by those that are there: b2 alone may be negative."""
    model = ARDRSC(XI, 0.02, -0.03)
    assert np.linalg.eigvalsh(model.diffusion_tensor(np.diag([1.0, 0, 0]), np.eye(3)))[0] < 0.0
    path = (np.linspace(0.0, 5.0, 21), np.stack([FLOWS["simple-shear"]] * 21))
    assert follow_orientation(model, CLOSURES["IBOF"], path, isotropic()).violation < 1e-12


def test_no_tensors_at_all() -> None:
    """As a sweep may be left with none: shapes go through, as everywhere."""
    found = follow_orientation(
        FolgarTucker(XI, 0.01), CLOSURES["ORE"], simple_shear(1.0, 2.0, 5), np.zeros((0, 3, 3))
    )
    assert found.a.shape == (0, 5, 3, 3)
    assert found.error.shape == (0,)


def test_why_no_step_is_taken_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Aligned fibers turn along the edge of the true tensors; a Runge-Kutta stage lies beyond."""
    monkeypatch.setattr(evolve, "MOST_STEPS", 20)
    aligned = np.diag([1.0, 0.0, 0.0])
    with pytest.raises(ConvergenceError, match=r"refused, exact closure: .* perfectly aligned"):
        follow_orientation(Jeffery(XI), EXACT, simple_shear(1.0, 2.0, 5), aligned)
    nearly = np.diag([1.0 - 2e-4, 1e-4, 1e-4])
    found = follow_orientation(Jeffery(XI), EXACT, simple_shear(1.0, 2.0, 5), nearly)
    assert found.violation == 0.0
