"""One melt for a study: a card, what the study says otherwise, and what stages read of both."""

import tomllib

import numpy as np
import pytest

from fibermelt.engine.stages import Parameters, keys
from fibermelt.engine.toml import resolved_toml
from fibermelt.errors import ConfigError
from fibermelt.melt import CarreauYasuda, Cross, Newtonian, PowerLaw
from fibermelt.parts.melt.cards import material_names
from fibermelt.parts.melt.melt import law_of, melt_notes, melt_of, newtonian_viscosity
from fibermelt.study.chain import CHAIN
from fibermelt.study.loading import load_study, merged, resolve

BEAD = {"parts": ["bead"]}
CARREAU = {"law": "carreau", "viscosity": "5 kPa s", "index": 0.4, "time_constant": "0.2 s"}
SHIFTED = """
name = "shifted"
[melt]
density = { value = 1000.0, source = "made up" }
temperature = { value = "230 degC", source = "made up" }
coldest = { value = "200 degC", source = "made up" }
hottest = { value = "260 degC", source = "made up" }
[viscosity]
law = { value = "carreau", source = "made up" }
viscosity = { value = "2 kPa s", source = "made up" }
index = { value = 0.4, source = "made up" }
time_constant = { value = "0.1 s", source = "made up" }
temperature = { value = "230 degC", source = "made up" }
activation_temperature = { value = "12000 K", source = "made up" }
slowest = { value = "1 1/s", source = "made up" }
fastest = { value = "500 1/s", source = "made up" }
"""
A_240 = float(np.exp(12000.0 * (1 / 513.15 - 1 / 503.15)))


def study(**melt):
    return resolve({"study": BEAD, "melt": melt})


@pytest.fixture
def shifted(tmp_path):
    path = tmp_path / "shifted.toml"
    path.write_text(SHIFTED)
    return str(path)


def test_the_papers_melt():
    melt = melt_of(load_study("paper").config.melt)
    assert (melt.law, melt.temperature, melt.density) == (Newtonian(817.0), 503.15, 1154.0)
    assert (melt.measured_at, melt.rates) == (None, (100.0, 100.0))
    assert melt == melt_of(resolve({}).melt)


@pytest.mark.parametrize("name", material_names())
def test_a_resolved_study_says_all_of_its_melt(name):
    config = resolve({"study": {"parts": ["interaction"]}, "melt": {"material": name}})
    again = resolve(tomllib.loads(resolved_toml(config, "")))
    assert again == config
    assert again.values() == config.values()


@pytest.mark.parametrize(
    ("name", "at_100", "n"),
    # Viscosities [Pa s] at 100 1/s of the sources' constants by hand, to the last digit.
    [("abs-cf13-thinning", 821.3, 0.5), ("made-up-carreau", 817.0, None), ("abs", 407.0, None)],
)
def test_shipped_laws_have_the_viscosities_of_their_sources(name, at_100, n):
    law = melt_of(study(material=name).melt).law
    assert float(law.viscosity_at(100.0)) == pytest.approx(at_100, rel=2e-4)
    assert n is None or float(law.index_at(100.0)) == pytest.approx(n, abs=1e-6)


@pytest.mark.parametrize(("celsius", "at_rest"), [(210, 4628), (230, 2007), (250, 1027)])
def test_cross_wlf_follows_the_temperature(celsius, at_rest):
    law = melt_of(study(material="abs", temperature=f"{celsius} degC").melt).law
    assert isinstance(law, Cross)
    assert law.viscosity == pytest.approx(at_rest, abs=0.5)
    assert law.critical_stress == 30820.0


def test_arrhenius_shifts_viscosity_and_time(shifted):
    melt = melt_of(study(material=shifted, temperature="240 degC").melt)
    assert melt.law == CarreauYasuda(A_240 * 2000.0, 0.4, A_240 * 0.1)
    assert (melt.measured_at, melt.rates) == (None, (1.0, 500.0))
    assert melt_of(study(material=shifted).melt).law == CarreauYasuda(2000.0, 0.4, 0.1)


def test_a_viscosity_of_another_temperature_is_told(shifted):
    warmer = study(temperature="240 degC")
    assert melt_of(warmer.melt).measured_at == 503.15
    assert melt_of(warmer.melt).law == Newtonian(817.0)
    (note,) = melt_notes(warmer)
    assert note.startswith("the viscosity is that of 230 degC, the melt's temperature 240 degC")
    assert melt_notes(study()) == melt_notes(study(temperature="446 degF")) == []
    assert melt_notes(study(material=shifted, temperature="240 degC")) == []
    # What a study says of its viscosity holds at its temperature.
    assert melt_notes(study(temperature="240 degC", viscosity=700.0)) == []


def test_another_law_takes_none_of_the_cards_constants():
    melt = study(**CARREAU).melt
    assert (melt.viscosity, melt.infinite_viscosity, melt.transition) == (5000.0, 0.0, 2.0)
    power = study(law="power-law", consistency=8000.0, index=0.6).melt
    assert power.viscosity is None
    assert melt_of(study(law="power-law", consistency=8000.0, index=0.6).melt).law == PowerLaw(
        8000.0, 0.6
    )


def test_part_of_a_cards_law_may_be_the_studys(shifted):
    assert melt_of(study(material=shifted, index=0.3).melt).law == CarreauYasuda(2000.0, 0.3, 0.1)
    assert melt_of(study(material=shifted, viscosity=900.0).melt).law == CarreauYasuda(
        900.0, 0.4, 0.1
    )
    with pytest.raises(ConfigError, match=r"^melt\.law_temperature: missing: .*melt\.visc"):
        study(material=shifted, viscosity=900.0, temperature="240 degC")
    told = study(
        material=shifted, viscosity=900.0, temperature="240 degC", law_temperature="230 degC"
    )
    assert melt_of(told.melt).law == CarreauYasuda(A_240 * 900.0, 0.4, A_240 * 0.1)


def test_another_melt_or_law_begins_anew():
    below = {"melt": {"material": "paper", "viscosity": 500.0, "density": 1100.0}}
    assert merged(below, {"melt": {"material": "pla"}})["melt"] == {"material": "pla"}
    assert merged(below, {"melt": {"viscosity": 400.0}})["melt"] == {
        **below["melt"],
        "viscosity": 400.0,
    }
    assert merged(below, {"melt": {"law": "cross"}})["melt"] == {
        "material": "paper",
        "density": 1100.0,
        "law": "cross",
    }


def test_stages_read_constants_and_no_card(tmp_path, shifted):
    def found(config):
        return keys(CHAIN.stages, config.values())

    base, same = found(study()), found(study(law="newtonian", viscosity="817 Pa s"))
    assert base == same
    thinner, warmer = found(study(viscosity=400.0)), found(study(temperature="240 degC"))
    assert {name for name in base if base[name] != warmer[name]} == {"voids", "claims"} - {"claims"}
    # A flow is one with its multiples: who is fed it has the scale.
    assert base["flow"] == thinner["flow"]
    assert base["streamlines"] != thinner["streamlines"]
    before = found(study(material=shifted))["streamlines"]
    words = tmp_path / "shifted.toml"
    words.write_text(SHIFTED.replace('"made up"', '"in other words"'))
    assert found(study(material=shifted))["streamlines"] == before
    words.write_text(SHIFTED.replace("2 kPa s", "3 kPa s"))
    assert found(study(material=shifted))["streamlines"] != before


THINS = {"law": "carreau", "viscosity": 5000.0, "index": 0.4, "time_constant": 0.2}


@pytest.mark.parametrize(
    ("tables", "says"),
    [
        ({"study": {"parts": ["bead", "orbits"]}}, r'study\.parts: "orbits" .* \["bead"\]'),
        (
            {"fiber": {"model": "spheroid", "aspect_ratio": 30.0}},
            r'fiber\.aspect_ratio = 30: .* or take fiber\.model = "ellipse"',
        ),
        (
            {"fiber": {"model": "spheroid", "directions": "equal-area"}},
            r'fiber\.directions = "equal-area": .* "in-plane"',
        ),
        ({"numerics": {"cell_mesh": "paper"}}, r'numerics\.cell_mesh = "paper": .* "graded"'),
        (
            {"fiber": {"melt": "local-viscosity", "path": "newton"}},
            r'fiber\.path = "newton" with fiber\.melt = "local-viscosity"',
        ),
    ],
)
def test_what_has_no_answer_in_a_melt_that_thins(tables, says):
    with pytest.raises(ConfigError, match=says):
        resolve({"melt": THINS, **tables})
    assert resolve({"melt": {**THINS, "index": 1.0}, **tables})


def test_the_local_viscosity_is_told_where_it_matters():
    local = {"fiber": {"melt": "local-viscosity"}}
    (note,) = melt_notes(resolve({"melt": THINS, **local}))
    assert note.startswith('fiber.melt = "local-viscosity"')
    assert melt_notes(resolve(local)) == melt_notes(resolve({"melt": THINS})) == []


def test_only_a_melt_that_thins_at_fibers_has_a_table():
    def feeding(**tables):
        values = resolve(tables).values()
        return [stage.name for stage in CHAIN.needed(["bead"], values)]

    assert "response" not in feeding()
    assert "response" not in feeding(melt={**THINS, "index": 1.0})
    assert "response" not in feeding(melt=THINS, fiber={"melt": "local-viscosity"})
    assert {"response", "surroundings"} <= {*feeding(melt=THINS)}
    # without a cell there is no flow around it to be solved
    assert "surroundings" not in feeding(melt=THINS, fiber={"model": "ellipse"})
    assert "surroundings" not in feeding()


def test_a_law_is_read_at_the_melts_temperature(shifted):
    values = study(material=shifted, temperature="240 degC").values()
    read = Parameters({key: value for key, value in values.items() if key.startswith("law.")})
    assert law_of(read) == CarreauYasuda(A_240 * 2000.0, 0.4, A_240 * 0.1)
    with pytest.raises(ConfigError, match=r'^melt\.law = "carreau": must be "newtonian" here'):
        newtonian_viscosity(read)


@pytest.mark.parametrize(
    ("melt", "says"),
    [
        (
            {"material": "papr"},
            r"^melt\.material: no material is called \"papr\"; did you mean",
        ),
        ({**CARREAU, "index": 0.0}, r"^melt\.index = 0\.0: must be above 0$"),
        ({**CARREAU, "index": -1.0}, r"^melt\.index = -1\.0: must be above 0$"),
        ({**CARREAU, "index": 2.5}, r"^melt\.index = 2\.5: must be at most 2$"),
        ({**CARREAU, "law": "bingham"}, r'^melt\.law = "bingham": must be "newtonian" or "power-l'),
        (
            {"law": "carreau"},
            r"^melt\.viscosity, melt\.index, melt\.time_constant: missing: ",
        ),
        (
            {"material": "pei"},
            r'^melt\.law: missing: the card melt\.material = "pei" knows',
        ),
        (
            {"material": "ps"},
            r"^melt\.critical_stress: missing: melt\.law = \"cross-wlf\" cann",
        ),
        ({"index": 0.5}, r'^melt\.index = 0\.5: is no constant of melt\.law = "newtonian", which'),
        (
            {"temperature": "300 degC"},
            r"^melt\.temperature = 573\.15 K: must be from 473\.15 to",
        ),
        ({"temperature": 240}, r'^melt\.temperature = 240: .*write "240 degC"$'),
        (
            {**CARREAU, "infinite_viscosity": "6 kPa s"},
            r"^melt\.infinite_viscosity = 6000 Pa s must be at least 0 and below melt\.viscosity",
        ),
        (
            {"law": "power-law", "consistency": 1e-3, "index": 0.1},
            r'^melt\.law = "power-law": its viscosity at 64000 1/s is .* Pa s, must be from 1',
        ),
        (
            {"material": "abs", "reference_temperature": "539 K", "temperature": "230 degC"},
            r'^melt\.law = "cross-wlf": its viscosity at rest is .*to 1e\+12 Pa s',
        ),
        (
            {"material": "abs", "reference_temperature": "600 K", "temperature": "230 degC"},
            r"^melt\.temperature = 503\.15 K must lie above 548\.4 K",
        ),
    ],
)
def test_what_is_no_melt_is_refused(melt, says):
    with pytest.raises(ConfigError, match=says):
        study(**melt)


def test_a_study_without_a_flow_needs_no_viscosity():
    config = resolve({"study": {"parts": ["interaction"]}, "melt": {"material": "pei"}})
    assert config.melt.missing == ("melt.law",)
    with pytest.raises(ConfigError, match=r"^melt\.law: missing"):
        melt_of(config.melt)


@pytest.mark.parametrize(("key", "value"), [("material", "pla"), ("temperature", "230 degC")])
def test_old_keys_name_the_new_ones(key, value):
    with pytest.raises(ConfigError, match=rf"^voids\.{key}: .* did you mean melt\.{key}\?$"):
        resolve({"voids": {key: value}})
