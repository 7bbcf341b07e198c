"""Paths through a bead in space: seeds of equal flux, stream tubes, stations, what lies near."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from round_bead import BEAD_PROBLEM, DIAMETER

from fibermelt.errors import ConfigError
from fibermelt.fields.bead import bead_paths, bead_seeds, bead_zones, followable
from fibermelt.fields.field import Field
from fibermelt.fields.paths import point_seeds, trace_field
from fibermelt.melt import CarreauYasuda, PowerLaw

if TYPE_CHECKING:
    from fibermelt.flow.space.bead import BeadSolution


@pytest.mark.parametrize("count", [1, 2, 3, 7, 22, 60, 301])
def test_seeds_halve_the_flux_of_their_rings(count: int) -> None:
    seeds = bead_seeds(BEAD_PROBLEM, count)
    assert len(seeds.points) == count
    assert seeds.flux == pytest.approx(0.5 * BEAD_PROBLEM.flux)
    x, _, z = seeds.points.T
    assert np.all(z > 0.0)
    assert np.all(np.diff(np.round(x / DIAMETER, 9)) >= 0.0)  # from the upstream side
    # a parabola's flux within each radius: the middles of rings of whole sectors
    rho = np.hypot(x, z) / (0.5 * DIAMETER)
    within, sectors = np.unique(np.round(1 - (1 - rho**2) ** 2, 9), return_counts=True)
    outer = np.cumsum(sectors) / count
    assert within == pytest.approx(outer - 0.5 * sectors / count, abs=1e-8)
    # as many to the left as to the right
    assert np.sum(x) == pytest.approx(0.0, abs=1e-9)


def test_seeds_follow_the_melts_own_profile() -> None:
    """Of index 1/2 ``u ~ 1 - rho^3``, and the flux within ``(5 rho^2 - 2 rho^5)/3``."""
    seeds = bead_seeds(replace(BEAD_PROBLEM, melt=PowerLaw(5000.0, 0.5)), 22)
    rho = np.unique(np.round(np.hypot(seeds.points[:, 0], seeds.points[:, 2]), 12))
    rho = rho / (0.5 * DIAMETER)
    newton = bead_seeds(BEAD_PROBLEM, 22)
    of_parabola = np.unique(np.round(np.hypot(newton.points[:, 0], newton.points[:, 2]), 12))
    of_parabola = of_parabola / (0.5 * DIAMETER)
    within = 1 - (1 - of_parabola**2) ** 2
    assert (5 * rho**2 - 2 * rho**5) / 3 == pytest.approx(within, abs=1e-6)
    level = bead_seeds(replace(BEAD_PROBLEM, melt=CarreauYasuda(817.0, 0.5, 1e-6)), 22)
    assert level.points == pytest.approx(newton.points, abs=1e-6 * DIAMETER)


def test_no_paths_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"streamlines\.count"):
        bead_seeds(BEAD_PROBLEM, 0)


@pytest.fixture(scope="module")
def field(coarse_bead: BeadSolution) -> Field:
    return followable(coarse_bead.field, coarse_bead.problem)


@pytest.mark.slow
@pytest.mark.verification
@pytest.mark.parametrize("share", [0.25, 0.5, 0.75, 0.9])
def test_stream_tubes_keep_their_flux(field: Field, share: float) -> None:
    """What enters within a circle leaves, at the bed's speed, through as much of the section."""
    radius = 0.5 * DIAMETER * np.sqrt(1.0 - np.sqrt(1.0 - share))
    angle = np.linspace(1e-3, np.pi - 1e-3, 33)
    top = BEAD_PROBLEM.nozzle.inlet_height - 1e-6 * DIAMETER
    circle = [radius * np.cos(angle), np.full(33, top), radius * np.sin(angle)]
    paths = trace_field(field, point_seeds(field, np.stack(circle, axis=-1)), 100)
    assert {path.end for path in paths} == {"outlet"}
    y, z = np.array([path.history.position[-1, 1:] for path in paths]).T
    area = abs(float(np.sum(y * np.roll(z, -1) - z * np.roll(y, -1))))  # of both halves
    chords = np.sinc(1.0 / 32.0)  # 32 of half a circle
    # 1.5e-3 here, 3e-4 on the default mesh: as the section's area and the inlet's flux are off
    assert area / chords / BEAD_PROBLEM.mass_balance_area == pytest.approx(share, abs=3e-3)


@pytest.mark.slow
@pytest.mark.verification
def test_all_paths_reach_the_outlet(field: Field) -> None:
    paths = bead_paths(field, BEAD_PROBLEM, 40, 200)
    nozzle = BEAD_PROBLEM.nozzle
    assert {path.end for path in paths} == {"outlet"}
    for path in paths:
        entrance, at_exit, settled = bead_zones(path, BEAD_PROBLEM)
        assert np.isnan(entrance)  # a straight nozzle
        assert 0.0 < at_exit < settled < path.history.time[-1]
        x, y, z = path.history.position.T
        lip = np.hypot(np.hypot(x, z) - 0.5 * DIAMETER, y - nozzle.gap).min()
        # near the lip, by the nodes around: within an edge of the bound
        assert (
            path.near_singularity == (lip < 0.15 * DIAMETER)
            or abs(lip - 0.15 * DIAMETER) < 0.15 * DIAMETER
        )
        assert path.divergence < 0.5
    # what is upstream in the nozzle comes to lie on the bed
    ends = np.array([path.history.position[-1, 1] for path in paths])
    assert ends[:5].mean() < 0.2 * DIAMETER < 0.5 * DIAMETER < ends[-5:].mean()


@pytest.mark.slow
@pytest.mark.verification
def test_nothing_crosses_the_plane_of_symmetry(field: Field) -> None:
    on_plane = field.points[:, 2] == 0.0
    assert on_plane.any()
    assert np.all(field.velocity[on_plane, 2] == 0.0)
    assert np.all(field.gradient[on_plane][:, [0, 1, 2, 2], [2, 2, 0, 1]] == 0.0)
