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


@pytest.mark.parametrize("study", ["pellet", "filament"])
def test_a_printer_is_moved_by_what_its_file_says(study: str) -> None:
    """What is pasted there moves the plane: by one factor each, or as mass balance has it."""
    base = values(study)
    of_printer = {step.lever: step.settings for step in steps_of(base)}
    keys = {key for settings in of_printer.values() for key in settings}
    assert {key for key in keys if key.startswith("flow.")} == {"flow.capillary_length"}
    moved = {
        "print speed and flow together": {"flow.inlet_speed": 0.95, "flow.bed_speed": 0.95},
        "width of the bead": {"flow.inlet_speed": 1.05, "flow.bed_speed": 1.0},
        "layer height": {"flow.gap": 0.95, "flow.inlet_speed": 0.95},
        "nozzle diameter": {
            "flow.capillary_width": 0.95,
            "flow.capillary_length": 0.95,
            "flow.inlet_speed": 0.95**-2,
            "flow.gap": 1.0,
        },
        "fiber content": {"interaction.volume_fraction": 0.8},
    }
    for lever, factors in moved.items():
        found = values(study, **of_printer[lever])
        assert {key: found[key] / base[key] for key in factors} == pytest.approx(factors, rel=1e-12)


@pytest.mark.parametrize("key", ["process.flow_rate", "process.mass_flow"])
def test_a_flow_that_is_said_goes_with_the_print_speed(key: str) -> None:
    said = {"process.flow_rate": "3.2 cm^3/s", "process.mass_flow": "14 kg/h"}
    base = values("pellet", **{key: said[key]})
    by_name = {step.lever: step for step in steps_of(base)}
    together = by_name["print speed and flow together"].settings
    assert together == pytest.approx({name: 0.95 * base[name] for name in together}, rel=1e-12)
    assert set(together) == {"process.print_speed", key}
    assert set(by_name["flow at the same print speed and layer height"].settings) == {key}
    assert by_name["layer height"].costs == ""


def test_what_the_plane_says_itself_is_moved_there() -> None:
    """``flow.gap`` wins over the layer height, which then moves no gap."""
    of_both = {
        step.lever: step.settings for step in steps_of(values("pellet", **{"flow.gap": 4e-3}))
    }
    assert of_both["gap between nozzle and bed"] == pytest.approx({"flow.gap": 3.8e-3})
    assert "layer height" not in of_both
    wider = values("pellet", **{"flow.gap": 4e-3, **of_both["width of the bead"]})
    assert wider["flow.gap"] == 4e-3


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
