"""Studies as people write them: what is accepted, and what is said of what is not."""

import math
import os
import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fibermelt.engine.parameters import declarations, flatten, quantity
from fibermelt.engine.toml import defaults_toml, resolved_toml, toml_value
from fibermelt.errors import ConfigError
from fibermelt.study.config import Config
from fibermelt.study.loading import load_study, preset_names, replaces_another, resolve

PAPER = load_study("paper").config
AS_BY_DEFAULT = PAPER.model_copy(
    update={
        "study": resolve({}).study,
        "interaction": PAPER.interaction.model_copy(update={"convention": "standard"}),
    }
)
"""The paper's study with the parts and the convention that a study has by default."""
EVERY = list(declarations(Config))


def study(folder, text):
    path = folder / "study.toml"
    path.write_text(text)
    return str(path)


def test_the_paper():
    assert PAPER.flow.inlet_speed == 0.024
    assert PAPER.flow.bed_speed == 0.1016
    assert PAPER.melt.viscosity == 817
    assert PAPER.fiber.half_length == 42e-6
    assert PAPER.fiber.domain_size == 4
    assert len(PAPER.fiber.initial_angles) == 13
    assert PAPER.fiber.initial_angles[0] == -math.pi / 2
    assert PAPER.flow.bead_height == pytest.approx(3e-3, rel=1e-15)


def test_the_defaults_are_the_paper():
    assert resolve({}) == AS_BY_DEFAULT


def test_every_preset_is_valid():
    assert "paper" in preset_names()
    for name in preset_names():
        load_study(name)


def test_a_study_starts_from_a_preset(tmp_path):
    path = study(tmp_path, 'preset = "paper"\n[flow]\ngap = "3.5 mm"\n')
    assert load_study(path).config.flow.gap == 0.0035
    assert load_study(path).config.melt == PAPER.melt


def test_a_preset_says_what_is_computed_too(tmp_path):
    written = study(tmp_path, 'preset = "paper"\n[voids]\nmoisture = "0.17 %"')
    assert load_study(written).config == PAPER
    with pytest.raises(ConfigError, match=r"^voids\.moisture = 17 %: must be at most"):
        load_study(study(tmp_path, 'preset = "paper"\n[voids]\nmoisture = "17 %"'))
    own = load_study(study(tmp_path, 'preset = "paper"\nstudy.parts = ["bead"]'))
    assert own.config.study.parts == ("bead",)
    assert "orbits" in load_study("sensitivity").config.study.parts
    assert "bead" not in load_study("sensitivity").config.study.parts


@pytest.mark.parametrize(
    "override", ["flow.gap=3.5 mm", 'flow.gap="3.5 mm"', "flow.gap = 0.0035", "flow.gap='3.5 mm'"]
)
def test_an_override_wins(tmp_path, override):
    path = study(tmp_path, 'preset = "paper"\n[flow]\ngap = "3.2 mm"\n')
    assert load_study(path, [override]).config.flow.gap == 0.0035


def test_overrides_of_lists_and_choices():
    config = load_study(
        "paper", ["fiber.initial_angles=['0 deg', 1.5]", "fiber.pressure_reference=far-node"]
    ).config
    assert config.fiber.initial_angles == (0.0, 1.5)
    assert config.fiber.pressure_reference == "far-node"


def test_numbers_are_si(tmp_path):
    path = study(tmp_path, "[flow]\ngap = 0.0031\nbed_speed = 1\n[fiber]\ninitial_angles = [0, 1]")
    config = load_study(path).config
    assert (config.flow.gap, config.flow.bed_speed) == (0.0031, 1.0)
    assert config.fiber.initial_angles == (0.0, 1.0)


ONE_LINE = [
    ("[flow]\ngapp = 3", r"^flow\.gapp: unknown key; did you mean flow\.gap\?$"),
    ("[flwo]\ngap = 3", r"^flwo: unknown key; did you mean \[flow\]\?$"),
    ("[melt]\ngap = 3", r"^melt\.gap: unknown key; did you mean flow\.gap\?$"),
    ('"flow.gap" = 3', r'^"flow\.gap": is one key in quotes: write gap under \[flow\]'),
    ("gap = 3", r"^gap: unknown key; did you mean flow\.gap\?$"),
    ("zzz = 3", r"^zzz: unknown key; `fibermelt defaults` prints every key there is$"),
    ('[flow]\ngap = "3 s"', r'^flow\.gap = "3 s": .*time, not length.* m, such as "3 mm"$'),
    ('[flow]\ngap = "3"', r'^flow\.gap = "3": has no unit.*such as "3 mm"$'),
    ("[flow]\ngap = true", r'^flow\.gap = true: is not a number in m.*"3 mm"$'),
    ("[flow]\ngap = nan", r"^flow\.gap = nan: is not finite"),
    ("[flow]\ngap = [1]", r"^flow\.gap = \[1\]: must be one number, above 0 m"),
    ('[flow]\ngap = "-1 mm"', r'^flow\.gap = "-1 mm": must be above 0 m$'),
    ("flow = 3", r"^flow = 3: is a table of parameters: write \[flow\]$"),
    (
        "[melt]\ntemperature = 230",
        r"^melt\.temperature = 230: must be at least 273\.16 K \(water's triple point\); a number "
        r'without unit is in K: for degrees Celsius write "230 degC"$',
    ),
    ("[melt]\ntemperature = 900", r"at most 647\.096 K \(water's critical point\)$"),
    ("[fiber]\naspect_ratio = 0.5", r"^fiber\.aspect_ratio = 0\.5: must be at least 1$"),
    (
        "[fiber]\ndomain_size = 1.9",
        r"^fiber\.domain_size = 1\.9: must be above 2 \(the fiber would be larger than its cell\)$",
    ),
    ("[fiber]\ninitial_angles = []", r"^fiber\.initial_angles = \[\]: at least one angle"),
    ("[fiber]\ninitial_angles = 3", r"^fiber\.initial_angles = 3: must be a list, such as"),
    (
        '[fiber]\ninitial_angles = ["0 deg", "1 m"]',
        r'^fiber\.initial_angles = .*: item 2 = "1 m" has the unit "m".*such as "-90 deg"$',
    ),
    (
        '[fiber]\npressure_reference = "maen"',
        r'^fiber\.pressure_reference = "maen": must be "mean" or "far-node"$',
    ),
    (
        "[streamlines]\ncount = 2.5",
        r"^streamlines\.count = 2\.5: must be a whole number, at least 1 and at most 1000$",
    ),
    ('preset = "papr"', r'^no study is called "papr"; did you mean paper\? \(shipped: .*paper'),
    ("preset = 3", r"^preset = 3: must be the name of a shipped study"),
    (
        '[flow]\ninlet_width = "2 mm"',
        r"^flow\.inlet_width = 0\.002 m is narrower than flow\.capillary_width = 0\.003175 m.*; "
        r"widen flow\.inlet_width or narrow flow\.capillary_width$",
    ),
    (
        '[flow]\noutlet = "4 mm"',
        r"^flow\.outlet = 0\.004 m lies too near the nozzle: at least 0\.0075875 m",
    ),
    ("[fiber]\naspect_ratio = 51", r"must be at most 50 \(the fiber's cell is verified in this"),
    ("[fiber]\ndomain_size = 2.005", r"must be at least 2\.01 \(the fiber's cell is verified in"),
    ("[fiber]\ndomain_size = 201", r"must be at most 200 \(the fiber's cell is verified in this"),
    ("[streamlines]\ncount = 1001", r"^streamlines\.count = 1001: must be at most 1000$"),
    ("[streamlines]\npoints = 20001", r"^streamlines\.points = 20001: must be at most 20000$"),
    ("[numerics]\nisotropic_angles = 10001", r"isotropic_angles = 10001: must be at most 10000$"),
    ('[flow]\ngap = "1001 mm"', r'^flow\.gap = "1001 mm": must be at most 1 m$'),
    ("[flow]\nbed_speed = 101", r"^flow\.bed_speed = 101: must be at most 100 m/s$"),
    ("[melt]\nviscosity = 1e-7", r"^melt\.viscosity = 1e-07: must be at least 1e-06 Pa s$"),
    ("[melt]\nviscosity = 1e13", r"viscosity = .*: must be at most 1e\+12 Pa s$"),
    ("[melt]\ndensity = 1e6", r"density = 1000000\.0: must be at most 100000 kg/m\^3$"),
    (
        "[flow]\ngap = 1e-5",
        r"^flow\.gap = 1e-05 m is 0\.00315 times flow\.capillary_width = 0\.003175 m: must be at "
        r"least 3\.175e-05 m",
    ),
    (
        "[flow]\ninlet_width = 0.4",
        r"^flow\.inlet_width = 0\.4 m is 126 times flow\.capillary_width = 0\.003175 m: must be at "
        r"most 0\.3175 m",
    ),
    (
        '[fiber]\nhalf_length = "0.8 mm"',
        r"^fiber\.half_length = 0\.0008 m is too long: its cell is 0\.0032 m across "
        r"\(fiber\.domain_size = 4 half-lengths\), flow\.capillary_width = 0\.003175 m; shorten",
    ),
    (
        "[fiber]\ninitial_angles = [0, -90]",
        r"^fiber\.initial_angles: item 2 = -90 rad: .*a bare number is in radians; write "
        r'"-90 deg"\)$',
    ),
    ("[fiber]\ninitial_angles = [[0]]", r'item 1 = "\[0\]" is not a number in rad'),
    ("[flow]\ngap = " + "1" * 400, r"^flow\.gap = 1{57}\.\.\.: is not finite"),
    ("[flow]\ngap = " + "1" * 5000, r"study\.toml: holds a number that is not finite: it has more"),
    ("[flow]\ngap = 0x" + "f" * 5000, r"^flow\.gap = \.\.\.: is not finite"),
    ("preset = 0x" + "f" * 5000, r"^preset = \.\.\.: must be the name of a shipped study"),
    ("gap = " + "[" * 5000, r"study\.toml: is nested too deeply: a parameter"),
    ("gap" * 2000 + " = 3", r"^(gap){19}\.\.\.: unknown key"),
    ('"ga\\np\\u001b" = 3', r"^ga\\np\\x1b: unknown key"),
    (
        '[fiber]\npressure_reference = "a\\n\\u001b[31m"',
        r'^fiber\.pressure_reference = "a\\n\\x1b\[31m": must be',
    ),
    (
        '[study]\nparts = ["beat"]',
        r'^study\.parts = \["beat"\]: each must be "bead" or "orientation" or',
    ),
    ('[study]\nparts = "bead"', r'^study\.parts = "bead": must be a list, such as \["bead"\]$'),
    ('[study]\nparts = ["claims"]', r'parts = \["claims"\]: nothing to judge them by; name "bead"'),
    ("[study]\nparts = []", r'^study\.parts = \[\]: name at least one, such as \["bead"\]$'),
    (
        "[sensitivity]\naspect_ratios = [3, 0.5]",
        r"^sensitivity\.aspect_ratios = \[3, 0\.5\]: item 2 = 0\.5: must be at least 1$",
    ),
    (
        "[streamlines]\nfeatures = [4, 0]",
        r"^streamlines\.features = \[4, 0\]: item 2 = 0: must be at least 1$",
    ),
    ("[sensitivity]\naspect_ratios = []", r"^sensitivity\.aspect_ratios = \[\]: at least one"),
    ("[sensitivity]\nviscosities = [1, 1]", r"^sensitivity\.viscosities: lists a value twice"),
    (
        "[flow]\ngap = 3 mm",
        r'study\.toml: not TOML: .*; a quantity stands in quotes: gap = "3 mm" \(at line 2, ',
    ),
    ('[flow]\ngap = "3 mm', r"study\.toml: not TOML: .*a quote is missing in this line"),
    (
        "[flow]\n[melt]\n[flow]",
        r"study\.toml: not TOML: the table \[flow\] is there twice: write all its keys under one",
    ),
    ('preset = "paper"\npreset = "paper"', r"study\.toml: not TOML: a key is there twice"),
    ("a = ", r"study\.toml: not TOML: .*\(at (line 1, column 5|end of document)\)$"),
]


@pytest.mark.parametrize(("text", "message"), ONE_LINE)
def test_one_line_says_what_is_wrong(tmp_path, text, message):
    with pytest.raises(ConfigError, match=message) as raised:
        load_study(study(tmp_path, text))
    assert len(str(raised.value).splitlines()) == 1
    assert str(raised.value).isprintable()


@pytest.mark.parametrize(
    "name", ["inlet_length", "taper_length", "capillary_length", "gap", "outlet"]
)
def test_lengths_are_those_of_one_nozzle(name):
    """A hundredth of the capillary's width to a hundred of it; the outlet has a bound nearer by."""
    width = PAPER.flow.capillary_width
    resolve({"flow": {name: 99.9 * width}})
    with pytest.raises(ConfigError, match=rf"flow\.{name} = .* 100 times flow\.capillary_width"):
        resolve({"flow": {name: 100.1 * width}})
    if name != "outlet":
        resolve({"flow": {name: 0.0101 * width}})
        with pytest.raises(ConfigError, match=rf"flow\.{name} = .*flow\.capillary_width"):
            resolve({"flow": {name: 0.0099 * width}})


def test_bounds_are_within():
    """The paper's study at the bounds themselves."""
    resolve(
        {
            "streamlines": {"count": 1000, "points": 20000},
            "fiber": {"aspect_ratio": 50, "domain_size": 2.01, "initial_angles": ["-360 deg"]},
            "numerics": {"isotropic_angles": 10000},
        }
    )
    resolve({"fiber": {"domain_size": 200, "half_length": "10 um"}})


def test_the_range_of_a_parameter_is_its_tightest():
    (domain_size,) = (item for item in EVERY if item.key == "fiber.domain_size")
    assert domain_size.range == 'at least 2.01 and at most 200 or "from-content"'


TABLES = sorted({item.key.partition(".")[0] for item in declarations(Config)})
WORDED = [item for item in declarations(Config) if item.words]


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("value", ["[{}]", "[1]", "[]"])
def test_a_list_of_tables_is_no_table(tmp_path, table, value):
    says = rf"^{table} = \[.*\]: is a table of parameters: write \[{table}\]$"
    for source, overrides in (
        (study(tmp_path, f"{table} = {value}"), []),
        ("paper", [f"{table}={value}"]),
    ):
        with pytest.raises(ConfigError, match=says):
            load_study(source, overrides)
    if value == "[{}]":
        with pytest.raises(ConfigError, match=says):
            load_study(study(tmp_path, f"[[{table}]]"))


@pytest.mark.parametrize("value", ["[]", "[0.1]", '["from-card"]'])
@pytest.mark.parametrize("item", WORDED, ids=lambda item: item.key)
def test_a_number_or_a_word_is_no_list(tmp_path, item, value):
    table, _, name = item.key.partition(".")
    for source, overrides in (
        (study(tmp_path, f"[{table}]\n{name} = {value}"), []),
        ("paper", [f"{item.key}={value}"]),
    ):
        with pytest.raises(ConfigError) as raised:
            load_study(source, overrides)
        assert str(raised.value).startswith(f"{item.key} = [")
        assert len(str(raised.value).splitlines()) == 1


def test_a_study_comes_through_a_pipe(tmp_path):
    reading, writing = os.pipe()
    os.write(writing, b"[flow]\ngap = 0.0035\n")
    os.close(writing)
    try:
        piped = load_study(f"/dev/fd/{reading}")
    finally:
        os.close(reading)
    assert piped.config.flow.gap == 0.0035
    assert piped.path is None


def test_a_byte_order_mark_is_no_fault(tmp_path):
    (tmp_path / "study.toml").write_bytes(b'\xef\xbb\xbfpreset = "paper"\n')
    assert load_study(str(tmp_path / "study.toml")).config.interaction == PAPER.interaction


def test_a_shipped_study_wins_over_a_folder_of_its_name(tmp_path, monkeypatch):
    (tmp_path / "paper").mkdir()
    (tmp_path / "mine").mkdir()
    monkeypatch.chdir(tmp_path)
    assert load_study("paper").config == PAPER
    with pytest.raises(ConfigError, match=r"^mine: is a folder, .*such as mine/study\.toml$"):
        load_study("mine")
    (tmp_path / "mine/config.toml").write_text("")
    with pytest.raises(ConfigError, match=r"^\./mine: is a folder, .* mine/config\.toml$"):
        load_study("./mine")


def test_where_a_study_came_from_is_told_on_one_line(tmp_path):
    path = tmp_path / "a\n\udcff.toml"
    path.write_text("")
    loaded = load_study(str(path), ["flow.gap\x1f=3.5 mm"])
    assert loaded.origin == r"a\n\udcff.toml, with flow.gap\x1f=3.5 mm"


def test_results_of_other_parameters(tmp_path):
    assert not replaces_another(tmp_path / "none", PAPER)
    (tmp_path / "config.toml").write_text(resolved_toml(PAPER, "as it was run"))
    assert not replaces_another(tmp_path, PAPER)
    assert replaces_another(tmp_path, load_study("paper", ["flow.gap=3.5 mm"]).config)
    (tmp_path / "config.toml").write_text("damaged")
    assert not replaces_another(tmp_path, PAPER)


def test_every_fault_has_its_line(tmp_path):
    text = "[flow]\ngap = -1\nwidth = 3\n[melt]\nviscosity = 'thick'\n[fiber]\naspect_ratio = 0"
    with pytest.raises(ConfigError) as raised:
        load_study(study(tmp_path, text))
    starts = [line.split(":")[0] for line in str(raised.value).splitlines()]
    assert starts == [
        "flow.gap = -1",
        "flow.width",
        'melt.viscosity = "thick"',
        "fiber.aspect_ratio = 0",
    ]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("papr", "did you mean paper"),
        ("nope.toml", "nope.toml: no such study file; the shipped studies are: .*paper"),
        ("no/where", "no/where: no such study file"),
        ("a" * 5000, r"^a{197}\.\.\.: no such study file: file name too long$"),
        ("x\ny", r'^no study is called "x\\ny"'),
        ("x\ny.toml", r"^x\\ny\.toml: no such study file"),
    ],
)
def test_a_study_that_is_not_there(name, message):
    with pytest.raises(ConfigError, match=message):
        load_study(name)


def test_a_study_that_is_no_text(tmp_path):
    (tmp_path / "study.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigError, match="byte 0 is not UTF-8"):
        load_study(str(tmp_path / "study.toml"))


@pytest.mark.parametrize("override", ["flow.gap", "=3", "flow..gap=3", ".=3", "a." * 999 + "a=3"])
def test_an_override_is_key_and_value(override):
    with pytest.raises(ConfigError, match="write it as key=value"):
        load_study("paper", [override])


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("flow.gapp=3.5 mm", r"flow\.gapp: unknown key; did you mean flow\.gap\?"),
        ("flow=3", "is a table of parameters"),
        ("flow.gap=" + "1" * 400, "is not finite"),
        ("flow.gap=" + "1" * 5000, r"^-s flow\.gap: holds a number that is not finite"),
        ("flow.gap=" + "[" * 5000, r"^-s flow\.gap: is nested too deeply"),
        ("flow.gap.x=3", r"flow\.gap = \{\.\.\.\}: is not a number in m"),
        ("flow.gap=1\nb=2", r"flow\.gap = .*the unit .* is not known|is not a number"),
    ],
)
def test_a_wrong_override(override, message):
    with pytest.raises(ConfigError, match=message):
        load_study("paper", [override])


def test_a_study_cannot_be_changed():
    with pytest.raises(ValueError, match="frozen"):
        PAPER.flow.gap = 1.0


@pytest.mark.parametrize("item", EVERY, ids=lambda item: item.key)
def test_every_parameter_is_fully_declared(item):
    assert item.doc.endswith(".")
    assert item.key in flatten(PAPER)
    if item.unit:
        assert item.example, "an error message could not say how to write it"


def test_defaults_are_a_study_with_every_key():
    tables = tomllib.loads(defaults_toml(Config))
    written = {f"{section}.{key}" for section, table in tables.items() for key in table}
    optional = {item.key for item in EVERY if item.written is None}
    assert written | optional == {item.key for item in EVERY}
    assert resolve(tables) == AS_BY_DEFAULT


@given(
    gap=st.floats(1e-4, 0.3),
    angles=st.lists(st.floats(-6.28, 6.28), min_size=1, max_size=40),
    contact=st.none() | st.floats(-1, 1),
)
def test_the_resolved_study_is_read_back_to_the_last_bit(gap, angles, contact):
    numerics = {} if contact is None else {"contact_guess": contact}
    config = resolve(
        {"flow": {"gap": gap}, "fiber": {"initial_angles": angles}, "numerics": numerics}
    )
    text = resolved_toml(config, "any\ntext")
    assert resolve(tomllib.loads(text)) == config


@given(st.text(st.characters(blacklist_categories=["Cs", "Cc"]) | st.sampled_from('\n\t\r"\\')))
def test_any_text_is_read_back(text):
    assert tomllib.loads(f"a = {toml_value(text)}")["a"] == text


def test_a_bound_has_a_known_name():
    with pytest.raises(TypeError, match="no bound"):
        quantity("1 m", "m", "A length.", above=0)


def test_a_preset_lends_what_it_has_from_another(tmp_path):
    """`nozzle` has the paper's parameters and its own parts; its sweep is not lent."""
    lent = load_study(study(tmp_path, 'preset = "nozzle"'))
    assert lent.sweep is None
    assert lent.config.study.parts == ("bead", "claims")
    assert lent.config.interaction.convention == PAPER.interaction.convention == "paper"
