"""The chain's stages: what they read, and that a study and the solvers mean the same defaults."""

from dataclasses import astuple

import pytest

from fibermelt.engine.files import canonical, digest
from fibermelt.engine.stages import Stage, keys, stage_parameters
from fibermelt.engine.toml import defaults_toml
from fibermelt.fiber.cell_data import CellNumerics
from fibermelt.fiber.population import ISOTROPIC_COUNT
from fibermelt.paper.claims.judge import claims
from fibermelt.paper.claims.printed import printed_periods
from fibermelt.study.chain import CHAIN
from fibermelt.study.config import Config
from fibermelt.study.loading import load_study, preset_names, resolve

DEFAULTS = resolve({}).values()
NOT_OF_THE_FIBER = {"flow", "strand", "field", "streamlines", "verification"}
OF_THE_FIBER = {stage.name for stage in CHAIN.stages} - NOT_OF_THE_FIBER
BELOW_FLOW = {
    *("streamlines", "motion", "surroundings", "orientation", "dimensions", "thinning"),
    *("voids", "plane", "claims"),
}


def test_every_parameter_is_read_by_a_stage():
    read = {key for stage in CHAIN.stages for key in stage_parameters(stage, DEFAULTS)}
    # Of the melt they read what follows from it: the law at its temperature, and the card; of the
    # process what it lends to other tables.
    resolved = {key for key in DEFAULTS if key.startswith(("melt.", "process."))}
    assert read - resolved == set(DEFAULTS) - resolved - {"study.parts"}
    assert read & resolved == {"melt.temperature", "melt.density"}


def _read_of_facts():
    """Return what stages read of the package's data, besides parameters and inputs."""
    return {
        "orbits": [astuple(line) for line in printed_periods()],
        "claims": [[claim.id, claim.quantity, claim.unit] for claim in claims()],
    }


@pytest.mark.parametrize(
    ("stage", "version", "seal"),
    [("orbits", 2, "454c39af38d1"), ("claims", 1, "6a04afc9fec8")],
)
def test_facts_that_change_raise_the_version_of_their_stage(stage, version, seal):
    """No key has them: what was stored with other facts would count as up to date.

    Who changes a fact raises the version of its stage, and writes both down here.
    """
    (found,) = (one.version for one in CHAIN.stages if one.name == stage)
    assert (found, digest(canonical(_read_of_facts()[stage]))[:12]) == (version, seal)


def test_stages_come_after_their_inputs():
    seen = set()
    for stage in CHAIN.stages:
        assert set(stage.inputs) <= seen
        seen.add(stage.name)


@pytest.mark.parametrize(
    ("key", "changed"),
    [
        ("flow.gap", BELOW_FLOW | {"flow", "strand"}),
        ("streamlines.count", BELOW_FLOW),
        ("fiber.aspect_ratio", OF_THE_FIBER),
        ("interaction.volume_fraction", {"content", "orientation", "voids", "claims"}),
        ("interaction.model", {"orientation", "claims"}),
        ("sensitivity.shear_rate", {"orbits"}),
        (
            "fiber.initial_angles",
            {"motion", "surroundings", "dimensions", "thinning", "voids", "plane", "claims"},
        ),
        (
            "numerics.isotropic_angles",
            {"motion", "surroundings", "voids", "plane", "claims"},
        ),
        ("voids.moisture", {"voids"}),
        ("thinning.rate", {"thinning"}),
        (
            "numerics.thinning_order",
            {"response", "motion", "surroundings", "thinning", "voids", "plane", "claims"},
        ),
        ("fiber.melt", {"motion", "surroundings", "voids", "plane", "claims"}),
        ("melt.temperature", {"voids"}),
        ("melt.density", {"voids"}),
        # The flow itself is that of any Newtonian melt; who is fed it sees it in its own scale.
        (
            "law.viscosity",
            OF_THE_FIBER - {"stall", "content", "cell", "interaction"} | {"strand", "streamlines"},
        ),
        ("study.ladder", {"verification"}),
    ],
)
def test_a_change_reaches_what_depends_on_it(key, changed):
    before = keys(CHAIN.stages, DEFAULTS)
    value = DEFAULTS[key]
    other = value[1:] if isinstance(value, tuple) else type(value)(value * 2)
    after = keys(CHAIN.stages, {**DEFAULTS, key: other})
    assert {name for name in before if before[name] != after[name]} == changed


def test_the_cell_is_fed_by_the_content_where_it_decides_its_size():
    asked = {**DEFAULTS, "fiber.domain_size": "from-content"}
    given, found = (
        [stage.name for stage in CHAIN.needed(["bead"], values)] for values in (DEFAULTS, asked)
    )
    assert given == ["flow", "streamlines", "cell", "motion"]
    assert found == ["flow", "streamlines", "stall", "content", "cell", "motion"]


def test_every_part_has_its_name_and_its_stages():
    assert len({part.name for part in CHAIN.parts}) == len(CHAIN.parts)
    assert all(part.stages for part in CHAIN.parts if part.meaning)
    assert {name for part in CHAIN.parts for name in part.stages} <= {s.name for s in CHAIN.stages}


def test_a_study_and_the_cell_have_the_same_default():
    """A table that took it from the cell would load all of the fibers for `fibermelt defaults`."""
    assert DEFAULTS["numerics.cell_order"] == CellNumerics().order
    assert DEFAULTS["numerics.isotropic_angles"] == ISOTROPIC_COUNT


def test_a_table_that_no_part_reads_is_told(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text('preset = "paper"\nstudy.parts = ["bead"]\n[voids]\nmoisture = "0.1 %"\n')
    (line,) = CHAIN.unread(load_study(str(path)))
    assert line.startswith('[voids] is read by no part of this study, study.parts = ["bead"]')
    assert '"voids" reads it' in line
    path.write_text('preset = "paper"\n[voids]\nmoisture = "0.1 %"\n')
    assert CHAIN.unread(load_study(str(path))) == []
    # Stages read the law that follows from it.
    assert (
        CHAIN.unread(load_study("paper", ['study.parts=["bead"]', "melt.viscosity=1 kPa s"])) == []
    )
    assert len(CHAIN.unread(load_study("interaction", ["flow.gap=2 mm"]))) == 1
    assert CHAIN.unread(load_study("paper", ['study.parts=["bead"]', "melt.viscosity=1"])) == []
    path.write_text(
        'study.parts = ["orbits"]\n[flow]\ngap = "2 mm"\n[streamlines]\ncount = 7\n'
        '[voids]\nmoisture = "0.1 %"\n'
    )
    bead, voids = CHAIN.unread(load_study(str(path)))
    assert bead.startswith("[flow] and [streamlines] are read by no part of this study")
    assert bead.endswith('"bead" reads them: name that too, or leave them away')
    assert voids.startswith("[voids] is read by")
    path.write_text(defaults_toml(Config))
    assert CHAIN.unread(load_study(str(path))) == []


def test_a_table_that_varies_and_no_part_reads_is_told(tmp_path):
    varied = load_study("paper", ['study.parts=["bead"]'], ["voids.moisture=0.1 %, 0.2 %"])
    (line,) = CHAIN.unread(varied)
    assert line.startswith("[voids] is read by no part of this study")
    path = tmp_path / "study.toml"
    path.write_text(
        'preset = "paper"\nstudy.parts = ["bead"]\n[sweep]\n'
        '"flow.gap, voids.moisture" = [["3 mm", "0.1 %"], ["4 mm", "0.2 %"]]\n'
    )
    assert CHAIN.unread(load_study(str(path))) == [line]
    path.write_text(f'{defaults_toml(Config)}\n[sweep]\n"flow.gap" = [3e-3, 4e-3]\n')
    assert CHAIN.unread(load_study(str(path))) == []


@pytest.mark.parametrize("name", [name for name in preset_names() if load_study(name).sweep])
def test_a_shipped_sweep_varies_what_is_read(name):
    assert CHAIN.unread(load_study(name)) == []


def test_who_is_fed_a_flow_sees_its_scale():
    """A stage that read nothing of the melt itself would else be taken for that of another."""
    flow = next(stage for stage in CHAIN.stages if stage.name == "flow")
    fed = Stage("fed", 1, ("flow.gap",), ("flow",), lambda *given: None)
    one, other = (
        keys((flow, fed), {**DEFAULTS, "law.viscosity": viscosity}) for viscosity in (817.0, 400.0)
    )
    assert one["flow"] == other["flow"]
    assert one["fed"] != other["fed"]
