"""Material cards: what ships, what is said of a hole and of a fault."""

import math
import tomllib
from importlib.resources import files

import pytest

from fibermelt.engine.parameters import declarations
from fibermelt.errors import ConfigError
from fibermelt.parts.melt.cards import card_of, load_card, material_names
from fibermelt.parts.melt.values import CardValues
from fibermelt.units import parse

SHIPPED = [
    "abs",
    "abs-cf13-thinning",
    "abs-cf20",
    "abs-power-law",
    "made-up-carreau",
    "pa6-cf20",
    "pa66-gf30",
    "paper",
    "pei",
    "pla",
    "pla-cf14",
    "ps",
]
MOIST = ["abs-cf13-thinning", "abs-cf20", "pa6-cf20", "paper", "pei", "pla", "pla-cf14"]
"""Those that say how they hold moisture."""

WHOLE = """
name = "toy"
[melt]
density = { value = "1 g/cm^3", source = "made up" }
temperature = { value = "230 degC", source = "made up" }
coldest = { value = "200 degC", source = "made up" }
hottest = { value = "260 degC", estimate = "made up" }
[isotherm]
content = { value = "1 %", source = "made up" }
reference_temperature = { value = "20 degC", source = "made up" }
mixing_heat = { value = 0, source = "made up" }
[diffusion]
prefactor = { value = "1e-6 m^2/s", source = "made up" }
activation_energy = { value = "40 kJ/mol", source = "made up" }
[surface]
tension = { value = "40 mN/m", source = "made up" }
reference_temperature = { value = "20 degC", source = "made up" }
slope = { value = "-0.07 mN/(m K)", source = "made up" }
[wetting]
contact_angle = { value = "60 deg", source = "made up" }
"""


def card(folder, text):
    path = folder / "toy.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_what_ships():
    assert material_names() == SHIPPED


@pytest.mark.parametrize("name", MOIST)
def test_shipped_cards_give_margins_and_say_what_they_cannot(name):
    found = load_card(name)
    melt, T = found.melt, found.temperature
    moisture = 0.1 * float(melt.saturation_content(T))
    pressure = float(melt.vapor_pressure(moisture, T))
    assert 1e5 < pressure < 22.1e6
    assert float(melt.critical_moisture(pressure, T)) == pytest.approx(moisture, rel=1e-12)
    assert 10e-3 < melt.tension(T) < 40e-3
    for law in melt.gaps:
        assert getattr(melt, law) is None
        assert all(key.startswith(law) or law == "contact_angle" for key in melt.missing[law])
    # nobody has measured a melt on sized fibers
    assert "contact_angle" in melt.gaps
    assert melt.nucleation(moisture, T).wetting_factor == 1.0


@pytest.mark.parametrize("name", SHIPPED)
def test_every_value_of_a_card_says_where_it_is_from(name):
    text = files("fibermelt").joinpath("data", "materials", f"{name}.toml").read_text("utf-8")
    tables = tomllib.loads(text)
    own = {f"{s}.{k}" for s, table in tables.items() if s not in {"name", "like"} for k in table}
    found = load_card(name)
    lent = load_card(tables["like"]).provenance if "like" in tables else {}
    keys = own | {key for key in lent if not key.startswith("viscosity.")}
    assert set(found.provenance) == keys
    assert all(len(where.text) > 8 for where in found.provenance.values())
    assert set(found.estimates) < keys


def test_the_papers_melt():
    found = load_card("paper")
    assert found.temperature == 503.15
    assert found.moisture == 0.0017
    assert found.melt.density == 1154.0
    assert found.melt.tension(503.15) == pytest.approx(23.8e-3, rel=1e-12)
    # extrapolated value of the source's law, in cm2/s to two digits
    assert found.melt.diffusivity(503.15) == pytest.approx(2.3e-10, rel=0.01)
    pressure = found.melt.vapor_pressure([5e-4, 1e-3, 1.7e-3, 3e-3], 503.15)
    assert pressure == pytest.approx([0.28e6, 0.56e6, 0.95e6, 1.68e6], abs=0.005e6)
    # moisture is the polymer's: the fibers hold none
    molecules = found.melt.nucleation(1.7e-3, 503.15).molecules
    assert molecules == pytest.approx(0.87 * 1154 * 1.7e-3 / 0.018015 * 6.022e23, rel=1e-4)


def test_pei_holds_what_its_source_says():
    law = load_card("pei").melt.isotherm
    assert law.content == 0.0139
    # 1.39 % at 20 degC to 1.50 % at 100 degC is its mixing heat
    assert law.content * math.exp(-870 / 8.3145 * (1 / 373.15 - 1 / 293.15)) == pytest.approx(
        0.0150, abs=5e-5
    )


def test_parachor_behind_the_tension_of_pla():
    from fibermelt.voids import Parachor  # noqa: PLC0415  this test alone needs it

    unit = Parachor.of_structure({"C": 3, "H": 4, "ester O2": 1})
    surface = load_card("pla").melt.surface
    assert surface.tension == pytest.approx(float(unit.tension(72.06e-3 / 1240.0)), abs=0.05e-3)


def test_a_hole_names_its_keys_its_cost_and_the_way_out():
    melt = load_card("pla").melt
    assert "diffusion" in melt.gaps
    with pytest.raises(
        ConfigError,
        match=r"material PLA: diffusion\.prefactor, diffusion\.activation_energy: no value in the "
        r"card, so no critical time, no residence condition, no growth of bubbles; give it",
    ):
        melt.residence(483.15)


def test_bad_input_names_the_range_and_the_remedy():
    melt = load_card("paper").melt
    with pytest.raises(
        ConfigError, match=r"moisture = 0\.75 %: must be at most 0\.5 %, saturation at .*; dry"
    ):
        melt.vapor_pressure(0.0075, 503.15)
    with pytest.raises(
        ConfigError, match=r"temperature = 603\.15 K: must be from 473\.15 to 533\.15 K; .*card"
    ):
        melt.vapor_pressure(0.001, 603.15)
    with pytest.raises(ConfigError, match="a dry melt does not nucleate"):
        melt.nucleation(0.0, 503.15)


def test_a_whole_card_of_ones_own(tmp_path):
    found = load_card(card(tmp_path, WHOLE))
    melt = found.melt
    assert melt.gaps == {}
    assert found.moisture is None
    assert found.estimates == ["melt.hottest"]
    assert found.provenance["surface.tension"].written == "40 mN/m"
    # 60 degrees through the melt is 120 through the vapor: cos = -1/2
    assert melt.nucleation(1e-3, 500.0).wetting_factor == pytest.approx(27 / 32, rel=1e-12)


def test_declared_examples_can_be_written():
    for declaration in declarations(CardValues):
        if declaration.choices:
            assert declaration.example in declaration.choices
            continue
        value = parse(declaration.example, declaration.unit)
        for name, bound in declaration.bounds:
            assert value >= bound if name in {"gt", "ge"} else value <= bound


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('name = "toy"', "", "name: missing"),
        ('"1 g/cm^3"', '"-1 g/cm^3"', r"melt\.density = -1 g/cm\^3: must be above 0 kg/m\^3"),
        ('"40 mN/m"', '"40 s"', r'surface\.tension = 40 s: has the unit "s".*write it as "38\.5'),
        ('"40 mN/m"', '"40"', r"surface\.tension = 40: has no unit"),
        ("[surface]\ntension", "[surface]\ntention", r"tention: unknown key; did you mean surf"),
        ("[wetting]", "[wettings]", r"wettings: unknown key; did you mean wetting"),
        (', source = "made up" }\n[surface]', " }\n[surface]", "must say where it is from"),
        ('source = "made up" }\n[surface]', 'source = "" }\n[surface]', "must say where it is"),
        ('{ value = "40 mN/m", source = "made up" }', '"40 mN/m"', "surface.tension: must say"),
        ('density = { value = "1 g/cm^3", source = "made up" }\n', "", r"melt\.density: missing"),
        (
            '"230 degC"',
            "230",
            r'melt\.temperature = 230: must be at least 273\.16 K; .*"230 degC"$',
        ),
        ('"230 degC"', '"300 degC"', r"melt\.temperature = 300 degC: must lie between .*260 degC"),
        ("[melt]", "[melt", r"toy\.toml: not TOML: .*line"),
        ("[wetting]\ncontact_angle", "[surface.more]\ncontact_angle", "surface.more: must say"),
        ("[melt]", "moisture = 3\n[melt]", "moisture: must be a table"),
    ],
)
def test_faults(tmp_path, old, new, says):
    assert old in WHOLE
    with pytest.raises(ConfigError, match=says) as fault:
        load_card(card(tmp_path, WHOLE.replace(old, new, 1)))
    assert "toy.toml" in str(fault.value)


def test_no_such_card(tmp_path):
    with pytest.raises(ConfigError, match=r'"papr".*did you mean paper\? \(shipped: abs, abs-'):
        load_card("papr")
    with pytest.raises(ConfigError, match="cannot be read"):
        load_card(str(tmp_path))
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigError, match="byte 0 is not UTF-8"):
        load_card(str(binary))


def test_a_byte_order_mark_is_no_fault(tmp_path):
    path = tmp_path / "toy.toml"
    path.write_bytes(b"\xef\xbb\xbf" + WHOLE.encode())
    assert load_card(str(path)).melt == load_card(card(tmp_path, WHOLE)).melt


def test_a_card_like_another_has_its_values_and_its_own(tmp_path):
    whole = card(tmp_path, WHOLE)
    own = tmp_path / "own.toml"
    own.write_text(
        f'name = "own"\nlike = "{whole}"\n'
        '[surface]\ntension = { value = "30 mN/m", source = "made up" }\n'
    )
    found, base = load_card(str(own)), load_card(whole)
    assert (found.name, found.melt.density) == ("own", base.melt.density)
    assert (found.melt.surface.tension, found.melt.surface.slope) == (0.030, -7e-5)
    assert card_of(found.key, found.text) == found
    own.write_text(f'name = "own"\nlike = "{own}"\n')
    with pytest.raises(ConfigError, match=r"own\.toml: like = .*: must name another card"):
        load_card(str(own))


@pytest.mark.parametrize("name", SHIPPED)
def test_a_card_is_read_again_as_it_was_in_its_order(name):
    found = load_card(name)
    again = card_of(found.key, found.text)
    assert again == found
    assert again.estimates == found.estimates


def test_a_law_of_its_own_has_nothing_of_the_others():
    """The paper's card is Newtonian: its viscosity is no constant of a power law."""
    found = load_card("abs-cf13-thinning").viscosity
    assert (found.law, found.viscosity, found.consistency) == ("power-law", None, 8213.0)


def test_the_old_name_of_the_papers_melt_still_stands_for_it():
    assert load_card("abs-cf13") == load_card("paper")


LAW = '[viscosity]\nlaw = { value = "power-law", source = "made up" }\n'
N = 'index = { value = 0.5, source = "made up" }\n'
AT = 'temperature = { value = "230 degC", source = "made up" }\n'


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[viscosity]\n" + N, r"viscosity\.law: missing; index need it"),
        (LAW + N, r"viscosity\.temperature: missing: at which temperature"),
        (LAW + AT + N.replace("index", "transition"), r"no constant of the law \"power-law\""),
        (LAW + AT + N.replace("0.5", "0.0"), r"viscosity\.index = 0\.0: must be above 0"),
        (LAW + AT + N.replace("0.5", "2.5"), r"viscosity\.index = 2\.5: must be at most 2"),
        (LAW.replace("power-law", "bingham"), r'law = bingham: must be "newtonian" or "power-law"'),
    ],
)
def test_faults_of_a_law(tmp_path, text, says):
    with pytest.raises(ConfigError, match=says):
        load_card(card(tmp_path, WHOLE + text))
