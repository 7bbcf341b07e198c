"""Another solver's flow in space, as large as people have them: read, followed, at one go.

A duct of 104,000 points in Fluent's ASCII export, joined to tetrahedra, and a thousand paths of
equal flux of 1500 points each. Each time stands over that of finding as many points in the field as
the paths have, and their velocities, once: what no way of following can do without.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import fibermelt as fm
from fibermelt.fields.paths import flux_seeds, inflow_section, trace_field
from timing import seconds

NODES = 47
"""Points along each side: 104,000 in all."""

PATHS, POINTS = 1000, 1500


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write a square duct's slow waves, which no polynomial of the fit has."""
    side = np.linspace(0.0, 1.0, NODES)
    x, y, z = (axis.ravel() for axis in np.meshgrid(2.0 * side, side, side, indexing="ij"))
    u = np.sin(np.pi * y) * np.sin(np.pi * z)
    columns = [np.arange(1, x.size + 1), x, y, z, 2.0 - x, u, 0.0 * u, 0.0 * u]
    names = "nodenumber, x-coordinate, y-coordinate, z-coordinate, pressure, "
    names += "x-velocity, y-velocity, z-velocity"
    path = tmp_path_factory.mktemp("field") / "export"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=names, comments="")
    return path


def test_reading_and_paths(benchmark: BenchmarkFixture, file: Path) -> None:
    field = fm.read_field(file)
    seeds = flux_seeds(field, inflow_section(field), PATHS)
    paths = trace_field(field, seeds, POINTS)
    assert {path.end for path in paths} == {"outlet"}
    points = np.concatenate([path.history.position for path in paths])

    def look_up() -> None:
        field.velocity_at(field.locate(points))

    once = seconds(look_up)
    read = seconds(lambda: fm.read_field(file))
    traced = seconds(lambda: trace_field(field, seeds, POINTS))
    benchmark.pedantic(look_up, rounds=1)
    benchmark.extra_info["reading over a look-up"] = read / once
    benchmark.extra_info["1000 paths over a look-up"] = traced / once
    benchmark.extra_info["both, seconds here"] = read + traced
    print(
        f"\n{len(field.points):,} points, {PATHS} paths of {POINTS}: read in {read:.1f} s, "
        f"followed in {traced:.1f} s, {read + traced:.1f} s in all"
    )
