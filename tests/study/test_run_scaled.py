"""A flow of another melt, or with both speeds faster by one factor, is not solved again."""

import numpy as np
import pytest
from coarse_runs import COARSE, computed

from fibermelt.engine.store import Store

pytestmark = pytest.mark.end_to_end

SPEEDS = ("flow.inlet_speed=12 mm/s", "flow.bed_speed=50.8 mm/s")
THINNER = ("melt.viscosity=400 Pa s", *SPEEDS)


def solves(run):
    """Tell whether a run solved its flow."""
    return any("Newton step" in line for line in run.told)


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    out = tmp_path_factory.mktemp("scaled") / "out"
    computed(COARSE, out)
    return out


def test_the_same_flow_with_another_scale_is_scaled(once, tmp_path):
    scaled, solved = computed(COARSE, once, *THINNER), computed(COARSE, tmp_path / "out", *THINNER)
    assert any(line.startswith("flow: reused") for line in scaled.told)
    assert (solves(scaled), solves(solved)) == (False, True)
    flows = [record for record, _ in Store(once, ()).records() if record.stage == "flow"]
    assert len(flows) == 1
    ours, theirs = scaled.results, solved.results
    assert set(ours) == set(theirs)
    for name in ("contact_point", "inlet_pressure", "pressure", "extreme", "quantile_lowest"):
        # Whoever comes first, it is the same flow: only sums come in threads' order.
        one, other = ours[name].to_numpy(), theirs[name].to_numpy()
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-10 * np.abs(other).max())


def test_another_ratio_of_speeds_is_solved(once):
    assert solves(computed(COARSE, once, "flow.bed_speed=100 mm/s"))


def test_fresh_is_fresh(once):
    assert solves(computed(COARSE, once, *THINNER, fresh=True))
