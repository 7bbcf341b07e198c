"""From a printer to the planar study: what is lent, who wins, and what is told of it."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from pathlib import Path

import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from fibermelt.engine.parameters import flatten
from fibermelt.engine.stages import keys
from fibermelt.engine.toml import resolved_toml
from fibermelt.errors import ConfigError
from fibermelt.levers.steps import steps_of
from fibermelt.melt import CarreauYasuda, Newtonian, PowerLaw, ViscosityLaw
from fibermelt.melt.slit import SlitFlow
from fibermelt.parts.process.slot import SLOT, wall_rate_ratio
from fibermelt.study.chain import CHAIN
from fibermelt.study.config import Config
from fibermelt.study.loading import load_study, resolve
from fibermelt.sweeps.design import read_sweep
from fibermelt.sweeps.status import list_plan

DIAMETER, SPEED = 7.6e-3, 0.07
PRINTER = {
    "nozzle_diameter": "7.6 mm",
    "layer_height": "3.8 mm",
    "bead_width": "8.4 mm",
    "print_speed": "4 in/s",
}


def process(**more: object) -> dict[str, object]:
    return {"process": {**PRINTER, **more}}


def notes(**tables: object) -> str:
    return "\n".join(resolve(tables).notes())


def pipe_wall_rate(law: ViscosityLaw, diameter: float, speed: float) -> float:
    """Return the rate at a pipe's wall: ``8 U/d = 4 int_0^1 s^2 gamma_dot(s tau_w) ds``."""

    def rate(stress: float, highest: float) -> float:
        def missing(log_rate: float) -> float:
            return float(law.stress_at(math.exp(log_rate))) - stress

        return math.exp(brentq(missing, math.log(1e-12 * highest), math.log(2 * highest)))

    def apparent(wall: float) -> float:
        stress = float(law.stress_at(wall))
        return 4 * quad(lambda s: s**2 * rate(s * stress, wall), 1e-3, 1)[0]

    newtonian = 8 * speed / diameter
    return float(brentq(lambda wall: apparent(wall) / newtonian - 1, newtonian, 4 * newtonian))


def test_the_slot_has_the_wall_rate_of_the_round_nozzle() -> None:
    slit = SlitFlow(Newtonian(817.0), SLOT * DIAMETER, SPEED)
    assert slit.wall_rate == pytest.approx(8 * SPEED / DIAMETER, rel=1e-14)
    # Hagen and Poiseuille, 32 mu U/d^2
    assert slit.pressure_gradient / (32 * 817.0 * SPEED / DIAMETER**2) == pytest.approx(2 / 3)
    assert wall_rate_ratio(Newtonian(817.0), DIAMETER, SPEED) == pytest.approx(1, rel=1e-14)


@pytest.mark.parametrize("n", [0.8, 0.5, 0.3])
def test_what_a_power_law_does_to_the_walls_rate_is_exact(n: float) -> None:
    law = PowerLaw(8213.0, n, lowest_rate=1e-6)
    slit, pipe = SlitFlow(law, SLOT * DIAMETER, SPEED), 8 * SPEED / DIAMETER * (3 * n + 1) / (4 * n)
    # The law is level below its lowest rate, nine decades down: 1e-9 of the flux at most.
    assert wall_rate_ratio(law, DIAMETER, SPEED) == pytest.approx(slit.wall_rate / pipe, rel=1e-6)
    assert 1 < wall_rate_ratio(law, DIAMETER, SPEED) < 4 / 3


def test_of_another_law_the_power_law_that_touches_it_tells() -> None:
    law = CarreauYasuda(10390.0, 0.35, 0.5)
    found = SlitFlow(law, SLOT * DIAMETER, SPEED).wall_rate / pipe_wall_rate(law, DIAMETER, SPEED)
    # The index falls from 1 to that at the wall: the estimate is off by less than what it tells.
    assert found == pytest.approx(wall_rate_ratio(law, DIAMETER, SPEED), abs=0.02)
    assert found > 1.05


def test_the_papers_flow_comes_back_from_its_printer() -> None:
    paper = resolve({}).flow
    diameter = paper.capillary_width / SLOT
    mean = paper.inlet_speed * paper.inlet_width / paper.capillary_width
    printer = {
        "nozzle_diameter": diameter,
        "layer_height": paper.gap,
        "print_speed": paper.bed_speed,
        "flow_rate": mean * math.pi * diameter**2 / 4,
    }
    found = resolve({"process": printer}).flow
    for name in type(paper).model_fields:
        if name != "source":
            assert getattr(found, name) == pytest.approx(getattr(paper, name), rel=1e-14), name
    assert found.bead_height == pytest.approx(3e-3, rel=1e-14)


def test_the_flow_is_that_of_the_bead_of_the_volume_or_of_the_mass() -> None:
    bead = resolve(process())
    rate = 3.8e-3 * 8.4e-3 * 0.1016
    for given in ({"flow_rate": rate}, {"mass_flow": rate * bead.melt.density}):
        found = resolve(process(**given)).flow
        assert found.inlet_speed == pytest.approx(bead.flow.inlet_speed, rel=1e-14)
    mean = rate / (math.pi * DIAMETER**2 / 4)
    assert bead.flow.bead_height == pytest.approx(mean * SLOT * DIAMETER / 0.1016, rel=1e-14)


def test_content_by_weight_is_the_papers_by_volume() -> None:
    found = resolve({"process": {"fiber_weight_fraction": "13 %"}}).interaction.volume_fraction
    assert found == pytest.approx(0.13 * 1154 / 1780, rel=1e-14)
    assert round(found, 3) == 0.084


def test_what_flow_says_itself_wins_and_the_flow_is_the_same() -> None:
    lent = resolve(process()).flow
    for name, value in {"capillary_width": 5e-3, "inlet_width": 20e-3, "gap": 4e-3}.items():
        study = resolve({**process(), "flow": {name: value}})
        assert getattr(study.flow, name) == value
        assert study.flow.bead_height == pytest.approx(lent.bead_height, rel=1e-14)
        assert any(f"flow.{name} = {value:g} m is said, and wins" in one for one in study.notes())
    # All else is as it is without, but for the speed in another inlet.
    assert study.flow == lent.model_copy(update={"gap": 4e-3})
    assert "is said" not in notes(**process())


@pytest.mark.parametrize(
    "overrides",
    [
        ["process.layer_height=4 mm", "flow.gap=3.7 mm"],
        ["flow.gap=3.7 mm", "process.layer_height=4 mm"],
    ],
)
def test_overrides_have_no_order(overrides: Sequence[str]) -> None:
    flow = load_study("pellet", overrides).config.flow
    assert flow.gap == pytest.approx(3.7e-3)
    assert (
        flow.inlet_speed
        == load_study("pellet", ["process.layer_height=4 mm"]).config.flow.inlet_speed
    )


def test_the_process_of_a_file_wins_over_the_flow_of_its_preset(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('preset = "paper"\n[process]\nlayer_height = "3.2 mm"\n')
    flow, paper = load_study(str(path)).config.flow, load_study("paper").config.flow
    assert flow == paper.model_copy(update={"gap": 3.2e-3})
    assert load_study("paper", ["process.print_speed=80 mm/s"]).config.flow == paper.model_copy(
        update={"bed_speed": 80e-3}
    )


LAID = [
    [],
    ["process.layer_height=4 mm"],
    ["process.print_speed=80 mm/s"],
    ["flow.gap=4 mm"],
    ["flow.inlet_width=20 mm"],
    ["melt.density=1100 kg/m^3"],
    ["process.mass_flow=14 kg/h"],
    ["process.fiber_weight_fraction=10 %"],
]


@pytest.mark.parametrize("overrides", LAID, ids=" ".join)
def test_a_resolved_copy_is_the_study(tmp_path: Path, overrides: Sequence[str]) -> None:
    """What is laid over a copy, which says all of [flow], does what it does over the study."""
    given = ["process.mass_flow=13.5 kg/h"]
    study = load_study("pellet", given).config
    path = tmp_path / "config.toml"
    path.write_text(resolved_toml(study, "a copy"))
    copy = load_study(str(path), overrides).config
    left = [
        one for one in given if not one.startswith("process.mass") or "mass" not in str(overrides)
    ]
    laid = load_study("pellet", [*left, *overrides]).config
    assert copy == laid
    assert copy.notes() == laid.notes()
    for one in (copy, laid):
        assert one.flow.gap > 0  # both are whole
    stages = CHAIN.needed(study.study.parts, study.values())
    assert keys(stages, copy.values()) == keys(stages, laid.values())


@pytest.mark.parametrize("study", ["pellet", "filament"])
def test_a_lever_beside_a_run_is_what_is_pasted_into_its_study(study: str) -> None:
    """Levers are beside a finished run, whose tables are its resolved copy, all of [flow] said."""
    config = load_study(study).config
    tables, base = tomllib.loads(resolved_toml(config, "a copy")), flatten(config)
    for step in steps_of(config.values()):
        beside = flatten(load_study(tables, step.settings).config)
        assert beside == flatten(load_study(study, step.settings).config)
        changed = {key: value for key, value in beside.items() if value != base[key]}
        assert step.settings.items() <= changed.items()


@pytest.mark.parametrize("study", ["pellet", "paper"])
def test_a_sweep_over_the_process_is_each_of_its_studies(study: str) -> None:
    over = {"process.layer_height": ["3.7 mm", "4 mm"], "process.print_speed": ["80 mm/s", 0.1]}
    cases = read_sweep(load_study(study, (), over)).cases()
    assert len(cases) == 4
    for case in cases:
        alone = load_study(study, {key: case.point[key] for key in over}).config
        assert case.config == alone
        assert case.config.flow.gap == case.point["process.layer_height"]
        assert case.config.flow.bed_speed == case.point["process.print_speed"]


def test_a_sweep_over_the_melt_moves_what_is_lent() -> None:
    given = ["process.mass_flow=13.5 kg/h"]
    swept = load_study("pellet", given, {"melt.density": [1100.0, 1200.0]})
    light, heavy = (case.config for case in read_sweep(swept).cases())
    assert light.flow.inlet_speed / heavy.flow.inlet_speed == pytest.approx(12 / 11)
    assert heavy.interaction.volume_fraction == pytest.approx(0.2 * 1200 / 1780)


def test_a_sweep_over_flow_wins_over_the_process() -> None:
    swept = load_study("pellet", (), {"flow.gap": ["3.7 mm", "4 mm"]})
    assert [case.config.flow.gap for case in read_sweep(swept).cases()] == [3.7e-3, 4e-3]


@pytest.mark.parametrize("study", ["pellet", "paper"])
def test_what_a_sweep_of_the_process_sets_is_not_set_besides(study: str) -> None:
    with pytest.raises(ConfigError, match=r"-s flow\.gap=.*has no effect.*process\.layer_height"):
        load_study(study, ["flow.gap=4 mm"], ["process.layer_height=3.7 mm, 4 mm"])


def test_a_plan_tells_what_validate_tells(tmp_path: Path) -> None:
    swept = load_study("pellet", (), {"voids.moisture": [1e-4, 1e-3]})
    told = list_plan(read_sweep(swept), swept, CHAIN, tmp_path)["notes"]
    assert told == swept.config.notes()
    assert any("7.6 mm is a slot 5.7 mm wide" in note for note in told)


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        (process(layer_height="0 mm"), r'^process\.layer_height = "0 mm": must be above 0 m$'),
        (
            process(print_speed="99 m/s", layer_height="0.9 m"),
            r"^flow\.inlet_speed = .*: must be at most 100 m/s; flow\.inlet_speed follows from "
            r'process\.layer_height = "0\.9 m" and .*process\.nozzle_diameter = "7\.6 mm"$',
        ),
        (
            {"process": {"nozzle_diameter": "7.6 mm", "layer_height": "0.01 mm"}},
            r"^flow\.gap = 1e-05 m is 0\.00175 times flow\.capillary_width.*flow\.gap follows from "
            r'process\.layer_height = "0\.01 mm"',
        ),
        (
            {"process": {"fiber_weight_fraction": 0.9, "fiber_density": 1000.0}},
            r"^interaction\.volume_fraction = 1\.0386: must be below 1; .* follows from "
            r"process\.fiber_weight_fraction = 0\.9 and process\.fiber_density = 1000\.0$",
        ),
        (
            {"process": {"flow_rate": "3 cm^3/s"}},
            r"^process\.nozzle_diameter: missing: process\.flow_rate is of a flow",
        ),
        (
            {"process": {"nozzle_diameter": "7.6 mm", "bead_width": "8 mm", "layer_height": 3e-3}},
            r"^process\.print_speed: missing: process\.bead_width gives the flow together with",
        ),
        (
            process(mass_flow="14 kg/h", flow_rate="2 cm^3/s"),
            r"^process\.mass_flow = 0\.00388889 kg/s: is 3\.37e-06 m\^3/s at melt\.density = 1154 "
            r".*process\.flow_rate = 2e-06 m\^3/s: must agree within 10 %",
        ),
        (
            process(flow_rate="8 cm^3/s"),
            r"^process\.flow_rate = 8e-06: is .* times the bead's .*: must be from 0\.5 to 2",
        ),
    ],
)
def test_what_is_wrong_is_told_of_the_process(tables: dict[str, object], message: str) -> None:
    with pytest.raises(ConfigError, match=message) as raised:
        resolve(tables)
    assert len(str(raised.value).splitlines()) == 1


def test_a_flow_that_is_given_has_no_process(tmp_path: Path) -> None:
    file = tmp_path / "mine.vtu"
    file.write_text("the reader's own")
    given = {"flow": {"source": "field"}, "field": {"file": str(file)}}
    with pytest.raises(
        ConfigError, match=r'^process\.layer_height: is not read with flow\.source = "f'
    ):
        resolve({**given, "process": {"layer_height": 3e-3}})


def test_a_melt_that_cannot_be_read_is_the_one_fault() -> None:
    with pytest.raises(ConfigError) as raised:
        resolve({**process(mass_flow=0.004), "melt": {"material": "none"}})
    assert str(raised.value).startswith("melt.material: ")
    assert "process" not in str(raised.value)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"layer_height": "4.2 mm"}, ""),
        ({"bead_width": "9.5 mm"}, "above 1.1 the melt is pressed up the nozzle"),
        ({"bead_width": "6.5 mm"}, "below 0.9 the strand is drawn down"),
        ({"flow_rate": "4 cm^3/s"}, "the flow is 1.23 times layer height x bead width x"),
        ({"flow_rate": "2.5 cm^3/s"}, "more than 10 % less than the bead takes"),
        ({"flow_rate": "3 cm^3/s"}, ""),  # a bead with round sides
    ],
)
def test_a_bead_that_is_no_layer_is_told(more: dict[str, object], told: str) -> None:
    found = notes(**process(**more))
    assert told in found
    if not told:
        assert "above 1.1" not in found
        assert "below 0.9" not in found
        assert "more than 10 %" not in found


def test_what_is_not_given_and_so_the_papers_is_told() -> None:
    found = notes(process={"nozzle_diameter": "7.6 mm", "layer_height": "3.8 mm"})
    assert "flow.bed_speed (process.print_speed), flow.inlet_speed (process.flow_rate" in found
    assert "flow.gap (" not in found
    assert "are the paper's" not in notes(**process())


def test_a_melt_that_thins_is_told_what_the_slot_does_not_keep() -> None:
    melt = {"law": "power-law", "consistency": 8213.0, "index": 0.5}
    # (2n + 1)/(3n + 1) over 0.75
    assert "1.07 times that at the round nozzle's" in notes(**process(), melt=melt)
    assert "in a melt that thins" not in notes(**process())


def test_a_card_of_another_content_is_told() -> None:
    told = "is of a melt with 13 % of fibers by weight"
    assert told in notes(**process(fiber_weight_fraction="20 %"))
    assert "is of a melt" not in notes(**process(fiber_weight_fraction="13 %"))


def test_without_a_process_nothing_is_lent_and_nothing_told() -> None:
    assert resolve({}).notes() == []
    assert Config.lent({}) == {}
    assert resolve({"process": {}}) == resolve({})
