"""Paths through a field known at its nodes, against those through the flow itself."""

from __future__ import annotations

import numpy as np
import pytest
from exact_flows import ExactFlow, box, exact_field
from scipy.integrate import solve_ivp

from fibermelt.fields.paths import flux_seeds, inflow_section, trace_field

pytestmark = pytest.mark.verification

Array = np.ndarray

K = 4.0


def velocity(x: Array) -> Array:
    """Return an Arnold-Beltrami-Childress flow, carried along x."""
    X, Y, Z = K * x.T
    return np.column_stack(
        [
            1.8 + np.sin(Z) + 0.5 * np.cos(Y),
            0.7 * np.sin(X) + 0.4 * np.cos(Z),
            0.6 * np.sin(Y) + 0.5 * np.cos(X),
        ]
    )


def gradient(x: Array) -> Array:
    X, Y, Z = K * x.T
    L = np.zeros((len(x), 3, 3))
    L[:, 0, 1], L[:, 0, 2] = -0.5 * K * np.sin(Y), K * np.cos(Z)
    L[:, 1, 0], L[:, 1, 2] = 0.7 * K * np.cos(X), -0.4 * K * np.sin(Z)
    L[:, 2, 0], L[:, 2, 1] = -0.5 * K * np.sin(X), 0.6 * K * np.cos(Y)
    return L


ABC = ExactFlow("abc", "spatial", box, velocity, gradient, lambda x: x[:, 0])


def test_paths_in_space_converge() -> None:
    """The velocity between nodes is quadratic: of order three, and so are the positions."""
    field = exact_field(ABC, 8)
    seeds = flux_seeds(field, inflow_section(field), 12)
    misses, agreements = [], []
    for n in (8, 16, 32):
        paths = trace_field(exact_field(ABC, n), seeds, 400)
        worst = []
        for path in paths:
            h = path.history
            exact = solve_ivp(
                lambda _, x: velocity(x[None])[0],
                (0.0, h.time[-1]),
                h.position[0],
                method="DOP853",
                t_eval=h.time,
                rtol=1e-11,
                atol=1e-12,
            )
            worst.append(np.max(np.abs(exact.y.T - h.position)))
        assert {path.end for path in paths} == {"outlet"}
        misses.append(np.max(worst))
        agreements.append(max(path.consistency.steadiness for path in paths))
        assert max(path.consistency.transport for path in paths) < 1e-3
    orders = np.log2(np.array(misses[:-1]) / misses[1:])
    assert np.all(orders > 2.7)
    assert misses[-1] < 5e-6
    # the gradient is linear between nodes: of order two
    assert np.log2(agreements[1] / agreements[2]) == pytest.approx(2.0, abs=0.4)
