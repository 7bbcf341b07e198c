"""What an operator can move."""

from __future__ import annotations

import numpy as np
import pytest

from fibermelt.levers.cases import Case
from fibermelt.levers.recommend import proposals, ratio
from fibermelt.levers.steps import Step, steps_of
from fibermelt.parts.voids.answer import dry_enough
from fibermelt.study.loading import load_study


def case(*fibers: float) -> Case:
    return Case(fibers=np.array(fibers))


def values(study: str = "paper", **changes: object) -> dict[str, object]:
    return dict(load_study(study, changes).config.values())


def names(**changes: object) -> set[str]:
    return {step.lever for step in steps_of(values(**changes))}


def test_a_temperature_is_moved_only_where_the_viscosity_follows_it() -> None:
    assert "temperature of the melt" not in names()
    assert "temperature of the melt" in names(**{"melt.material": "abs", "study.parts": ["bead"]})
    assert "temperature of the melt" in names(**{"melt.activation_temperature": "10000 K"})


def test_a_printers_nozzle_is_told_as_the_slot_that_stands_for_it() -> None:
    of_printer = {step.lever for step in steps_of(values("pellet"))}
    assert "slot that stands for the nozzle" in of_printer
    assert "nozzle diameter" not in of_printer
    assert "nozzle diameter" in names()


def test_both_speeds_go_by_one_factor_and_back_by_as_much() -> None:
    base = values()
    (step,) = [one for one in steps_of(base) if one.lever == "print speed and flow together"]
    assert step.costs == "output"
    for key, to in step.settings.items():
        assert to == pytest.approx(0.95 * base[key])
        assert step.mirrored(base)[key] == pytest.approx(1.05 * base[key])


BASE = {"flow.gap": 3.0, "flow.capillary_width": 2.0, "flow.inlet_speed": 1.0}
GAP, NOZZLE, SLOW = (
    Step("gap", {"flow.gap": 2.85}),
    Step("nozzle", {"flow.capillary_width": 1.9}),
    Step("speed", {"flow.inlet_speed": 0.95}, "output"),
)


def test_what_helps_goes_together_and_what_hurts_is_turned_round() -> None:
    weighed = [(GAP, case(2.2)), (NOZZLE, case(1.0)), (SLOW, case(0.1))]
    tried = proposals(weighed, case(2.0), {}, BASE)
    turned = pytest.approx(3.15)
    assert tried[0] == {"flow.capillary_width": 1.9, "flow.gap": turned}
    assert tried[1] == {"flow.capillary_width": 1.9}
    # What costs output is no advice, whatever it brings.
    assert not any("flow.inlet_speed" in one for one in tried)


def test_within_the_flows_error_nothing_helps() -> None:
    weighed = [(GAP, case(1.995)), (NOZZLE, case(2.005))]
    assert proposals(weighed, case(2.0), {}, BASE) == []


def test_a_melt_that_boils_is_dried_to_half_of_where_it_boils() -> None:
    def target(limit: float | None, moisture: float) -> float | None:
        return dry_enough({"rest": {"boiling_moisture": limit}, "moisture": moisture})

    assert target(1.8114e-4, 1.7e-3) == 9.0e-5
    # What is known to a factor of two may boil, too.
    assert target(1.8114e-4, 1.1e-4) == 9.0e-5
    assert target(1.8114e-4, 9.0e-5) is None
    assert target(None, 1.7e-3) is None
    dried = {"voids.moisture": 9.0e-5}
    halved = Step("moisture", {"voids.moisture": 4e-4})
    weighed = [(halved, case(0.5)), (GAP, case(1.0))]
    tried = proposals(weighed, case(2.0), dried, BASE)
    assert tried == [{**dried, "flow.gap": 2.85}, dried]


def test_nothing_has_no_share() -> None:
    assert ratio(case(1.0), case(0.0)) is None
    assert ratio(Case(reason="no surface"), case(1.0)) is None
    assert ratio(case(1.0), case(4.0)) == 0.25
    assert ratio(case(0.02), case(0.04)) is None


def test_a_streamline_that_only_one_setting_keeps_is_no_effect_of_it() -> None:
    """Twice as much on each that both keep; means over what each keeps would say 3/2 and 4."""
    base, moved = case(1.0, np.nan, 2.0, 5.0), case(2.0, 8.0, 4.0, np.nan)
    assert ratio(moved, base) == pytest.approx(2.0, rel=1e-12)
    assert ratio(base, moved) == pytest.approx(0.5, rel=1e-12)
    assert ratio(case(np.nan, 1.0), case(1.0, np.nan)) is None


def test_volumes_of_gas_add_up() -> None:
    assert Case(gas=np.array([0.5, np.nan, 1.5])).void_fraction == pytest.approx(0.5, rel=1e-12)
