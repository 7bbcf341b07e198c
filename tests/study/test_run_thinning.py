"""The whole chain in a melt that thins, over one coarse flow: by its law, and by a local one."""

from __future__ import annotations

import numpy as np
import pytest
from coarse_runs import COARSE, Computed, computed

pytestmark = pytest.mark.end_to_end

MELT = ["melt.law=power-law", "melt.consistency=8213", "melt.index=0.5"]
CASES = {"law": [], "local-viscosity": ["fiber.melt=local-viscosity"]}
KEYS = ("rates", "shape_factors", "largest_pressures", "error_estimate")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Computed]:
    """What every case comes to; both go through one results folder."""
    out = tmp_path_factory.mktemp("thinning") / "out"
    asked = ('study.parts=["bead", "voids"]', *MELT)
    return {case: computed(COARSE, out, *asked, *overrides) for case, overrides in CASES.items()}


@pytest.mark.parametrize("case", CASES)
def test_figures_can_be_drawn(found: dict[str, Computed], case: str) -> None:
    assert {"melt", "history", "extremes", "voids"} <= found[case].drawn()


def test_the_table_is_told_with_its_errors(found: dict[str, Computed]) -> None:
    cell = found["law"].summary["cell"]
    assert tuple(cell["thinning"]) == KEYS
    assert cell["thinning"]["error_estimate"]["pressure"] < 5e-3
    # melts.md: the period hardly changes, and B from 1.034 towards 1
    assert 1.0 < cell["thinning"]["shape_factors"][0] < cell["shape_factor"]
    assert "thinning" not in found["local-viscosity"].summary["cell"]


def test_the_flow_is_the_same_and_its_melt_is_told(found: dict[str, Computed]) -> None:
    law, local = (found[case].summary["flow"] for case in CASES)
    assert law == local
    results = found["law"].results
    regular = results.isel(streamline=results["near_singularity"].to_numpy() == 0)
    rate = float(regular["shear_rate"].max())
    assert law["highest_rate"] == rate
    assert law["lowest_viscosity"] == pytest.approx(8213.0 * rate**-0.5, rel=1e-6)
    assert law["outside_law"] is None


def test_a_local_viscosity_overstates_the_pressure(found: dict[str, Computed]) -> None:
    law, local = (found[case].results for case in CASES)
    share = (law["bound_lowest"] / local["bound_lowest"]).to_numpy()
    # of a power law it is the same number everywhere: the largest pressures of both tables
    cell = found["law"].summary["cell"]
    expected = cell["thinning"]["largest_pressures"][0] / cell["tip_pressure"]
    assert share == pytest.approx(expected, rel=1e-3)
    assert 0.5 < expected < 0.6


def test_fibers_stay_within_the_bounds(found: dict[str, Computed]) -> None:
    results = found["law"].results
    lowest = results["lowest"].min("initial_angle") - results["bound_lowest"]
    slack = 1e-9 * float(np.abs(results["bound_lowest"]).max())
    assert float(lowest.min()) > -slack


def test_the_flow_around_a_fiber_is_solved_where_it_is_lowest(found: dict[str, Computed]) -> None:
    """The cell, solved once, has the pressure that the table has, and the fiber turns in it."""
    results = found["law"].results
    around = {name: results[f"around_{name}"].to_numpy() for name in ("point", "pressure")}
    at = results.sel(
        streamline=int(results["around_streamline"]),
        initial_angle=float(results["around_initial_angle"]),
    )
    when = int(np.argmin(np.abs(at["time"].to_numpy() - float(results["around_time"]))))
    lowest = float(at["lowest"][when])
    x, y = around["point"].T
    surface = np.hypot(x, y * float(results["aspect_ratio"])) < 1.0 + 1e-6
    # the table's own error over the largest pressure, and nodes that miss the lowest
    assert around["pressure"][surface].min() == pytest.approx(lowest, rel=2e-2)
    assert around["pressure"].min() == around["pressure"][surface].min()
    assert float(at["extreme_time"].sel(location=1, kind="min")) == float(results["around_time"])
    assert "around_pressure" not in found["local-viscosity"].results


def test_the_approximation_is_told(found: dict[str, Computed]) -> None:
    assert found["law"].summary.get("notes", []) == []
    (note,) = found["local-viscosity"].summary["notes"]
    assert note.startswith('fiber.melt = "local-viscosity"')


def test_spheroids_in_voids(found: dict[str, Computed]) -> None:
    """A shear-thinned spheroid sees less of a pressure than a Newtonian one, as an ellipse does."""
    law, local = (found[case].summary["voids"]["by_basis"] for case in CASES)
    assert list(law) == list(local)
    assert law["spheroid"]["lowest_pressure"] > local["spheroid"]["lowest_pressure"]
