"""Bubbles at the tips of the paper's fibers, with a hundred sizes of nuclei at each.

Their pressures are made up as those of fibers that turn; the melt is the paper's, at 0.05 %. Run
on one core: ``OMP_NUM_THREADS=1``.
"""

from __future__ import annotations

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fibermelt.melt import CarreauYasuda, ViscosityLaw
from fibermelt.voids import ATMOSPHERE, BubbleMelt, Surroundings, Tip, grow

STREAMLINES, ANGLES, NUCLEI, POINTS = 22, 13, 100, 1500
SWELL, BED = 0.45, 1.0
"""Time to zone 3, and on the bed after it [s]."""


def paths(law: ViscosityLaw | None) -> Surroundings:
    """Return what nuclei meet: a melt that comes from 0.4 MPa, and dips at the nozzle's exit."""
    t = np.linspace(0.0, 0.5, POINTS)
    deepest = np.linspace(-2e5, -8e5, STREAMLINES)[:, None, None]
    turn = 0.5 + 0.5 * np.cos(np.linspace(0.0, np.pi, ANGLES)[:, None] + 40.0 * t) ** 2
    dip = np.exp(-(((t - 0.3) / 0.02) ** 2))
    rate = 5.0 + 95.0 * dip
    return Surroundings(
        t,
        np.broadcast_to(ATMOSPHERE + 4e5 * np.clip(1.0 - t / 0.3, 0.0, 1.0), (1, 1, 1, POINTS)),
        817.0 if law is None else law.viscosity_at(rate),
        rate,
        (deepest * turn * dip)[:, :, None],
        Tip(42e-6, 7e-6, in_space=False),
    )


@pytest.mark.parametrize("law", [None, CarreauYasuda(10390.0, 0.35, 0.5)], ids=["newton", "thins"])
def test_nuclei(benchmark: BenchmarkFixture, law: ViscosityLaw | None) -> None:
    melt = BubbleMelt(2.8e5, 1.96e-6, 2.3e-10, 0.0238, 503.15, law)
    nuclei = np.geomspace(2e-7, 5e-6, NUCLEI)
    around = paths(law)
    found = benchmark.pedantic(
        grow, (around, melt, nuclei, 4.7e-14, [SWELL, SWELL + BED]), rounds=1
    )
    assert found.radius.shape[:-1] == (STREAMLINES, ANGLES, NUCLEI)
    water = found.vapor + found.dissolved
    assert np.abs(water / water[..., :1] - 1.0).max() < 1e-10
