"""The page of a sweep: what it tells of cases and claims, and that it is one file and no more."""

import re
from html.parser import HTMLParser

import numpy as np
import pytest
from swept_cases import (
    COMPUTED,
    GAP,
    GRID,
    NUMBERS,
    ONE_AT_A_TIME,
    VISCOSITY,
    made_up,
    sampled,
    with_errors,
)

from fibermelt.paper.claims.judge import claims
from fibermelt.report.sweep.computed import INDEX_USES, sources_told
from fibermelt.report.sweep.page import render_sweep
from fibermelt.report.sweep.tables import varied_told
from fibermelt.sweeps.axes import distribution_told
from fibermelt.sweeps.claims import swept_claims
from fibermelt.sweeps.table import sweep_table

PARABOLA = next(one for one in claims() if one.id == "parabola")
BOUND = PARABOLA.at_most
EMPTY = {"meta", "link", "img", "br"}


def by_gap(point):
    """Hold for gaps up to 3 mm."""
    return 0.5 * BOUND if point[GAP] <= 3.1e-3 else 2 * BOUND


def by_both(point):
    """Hold for a narrow gap and a thin melt only."""
    return 0.5 * BOUND if point[GAP] < 2.6e-3 and point[VISCOSITY] < 500 else 2 * BOUND


def always(point):
    return 0.5 * BOUND


def never(point):
    return 2 * BOUND


def finding(tmp_path, text, function, failed=()):
    collected = made_up(tmp_path, text, NUMBERS, failed, {"parabola": function})
    found = swept_claims(collected, sweep_table(collected))
    return next(one.finding for one in found if one.claim.id == "parabola")


@pytest.mark.parametrize(
    ("text", "function", "expected"),
    [
        (GRID, always, "holds throughout"),
        (GRID, never, "differs throughout"),
        (GRID, by_gap, "depends on gap"),
        (GRID, by_both, "depends on gap, viscosity"),
        (ONE_AT_A_TIME, by_gap, "depends on gap"),
        (ONE_AT_A_TIME, always, "holds throughout"),
        (sampled("latin-hypercube", 4), always, "holds throughout"),
        (GRID, lambda point: float("nan"), "cannot be judged"),
        (
            GRID,
            lambda point: float("nan") if point[GAP] > 3.1e-3 else 0.5 * BOUND,
            "holds where it can be judged (4 of 6 cases)",
        ),
    ],
)
def test_what_a_claim_depends_on_follows_from_its_values(tmp_path, text, function, expected):
    assert finding(tmp_path, text, function) == expected


def test_samples_do_not_tell_what_a_claim_depends_on(tmp_path):
    told = finding(tmp_path, sampled("latin-hypercube", 8), by_gap)
    assert re.fullmatch(r"holds in [1-7] of 8 cases", told)


def test_a_failed_case_says_nothing_of_a_claim(tmp_path):
    # Without the two cases at 4 mm it holds in all that have an answer.
    assert finding(tmp_path, GRID, by_gap, failed={4, 5}) == "holds throughout"
    assert finding(tmp_path, GRID, by_gap, failed=set(range(6))) == "no case has an answer"


def test_two_changes_at_once_are_no_dependence(tmp_path):
    # Left are 2.5 mm with 400 Pa s, where it holds, and 4 mm with 800 Pa s, where it does not.
    told = finding(tmp_path, GRID, by_gap, failed={1, 2, 3, 4})
    assert told == "holds in 1 of 2 cases"


class Reader(HTMLParser):
    """Reads a page: its addresses, its words, and that every element that opens is closed."""

    def __init__(self):
        super().__init__()
        self.open, self.addresses, self.names, self.words = [], [], [], []
        self.cells, self.alts = [], []

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.addresses += [given[key] for key in ("src", "href") if key in given]
        self.names += [given["id"]] if "id" in given else []
        if tag == "img":
            self.alts.append(given["alt"])
        if tag not in EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not {"style", "script"} & set(self.open):
            self.words.append(data)


def read(page):
    reader = Reader()
    reader.feed(page.decode())
    reader.close()
    assert reader.open == []
    return reader, re.sub(r"\s+", " ", " ".join(reader.words))


def page_of(tmp_path, text=GRID, failed=(), function=by_gap):
    return render_sweep(made_up(tmp_path, text, NUMBERS, failed, {"parabola": function}))


def test_the_page_needs_nothing_else_and_is_the_same_each_time(tmp_path):
    page = page_of(tmp_path)
    reader, _ = read(page)
    # Sources have links, which nothing follows but a person.
    others = [one for one in reader.addresses if not one.startswith(("data:", "#"))]
    assert all(one.startswith("https://doi.org/") for one in others)
    assert all(address[1:] in reader.names for address in reader.addresses if address[0] == "#")
    assert len(set(reader.names)) == len(reader.names)
    assert all(reader.alts)
    assert b"<script" not in page
    assert page_of(tmp_path) == page


def test_the_page_says_what_varied_and_why_cases_failed(tmp_path):
    _, words = read(page_of(tmp_path, failed={5}))
    assert "3 × 2 cases: every combination." in words
    assert "2.5, 3, 4" in words
    assert "5 of 6 cases have an answer, 1 failed." in words
    assert "gap 4 mm, viscosity 800 Pa s no steady surface; try a larger gap" in words


def test_verdicts_have_a_word_for_who_does_not_see_the_sign(tmp_path):
    page = page_of(tmp_path, ONE_AT_A_TIME)
    assert page.decode().count('<span class="heard">holds</span>') == 5
    assert page.decode().count('<span class="heard">differs</span>') == 1
    _, words = read(page)
    assert "0 hold throughout, 0 differ throughout, 1 depend on what varied" in words
    assert "depends on gap" in words
    statements = {claim.statement for claim in claims()}
    assert f"{len(claims())} tests of {len(statements)} statements of the paper, judged" in words
    # What no case can judge stands apart, with the reason.
    assert f"{len(claims()) - 1} tests that no case can judge" in words


def test_many_cases_share_columns(tmp_path):
    text = f'"{GAP}" = ["2.5 mm", "4 mm"]\n"{VISCOSITY}" = {{ from = 400, to = 800, count = 10 }}'
    _, words = read(page_of(tmp_path, text, function=by_both))
    assert "3 of 10 hold" in words


def test_a_number_in_the_store_turns_the_verdict(tmp_path):
    before, after = (read(page_of(tmp_path, function=one))[1] for one in (always, never))
    assert "holds throughout" in before
    assert "holds throughout" not in after
    assert "differs throughout" in after


def test_what_a_file_says_is_no_markup(tmp_path):
    collected = made_up(tmp_path, GRID, NUMBERS, failed={0})
    collected["reason"][0, 0] = "<script>alert(1)</script>"
    collected.attrs["title"] = "fibermelt sweep <b>bold</b>"
    page = render_sweep(collected)
    assert b"<script" not in page
    assert b"&lt;b&gt;bold" in page


def test_samples_have_quantiles_and_one_column(tmp_path):
    _, words = read(page_of(tmp_path, sampled("sobol", 16)))
    assert "Quantiles of the responses over the cases" in words
    assert "all 16 cases" in words
    assert "16 cases: samples of a Sobol sequence, seed 3." in words
    assert "low 2.5 mm, high 4 mm" in words


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        ({"high": "4 mm", "low": 0.002}, "uniform, low 0.002, high 4 mm"),
        ({"std": 1, "between": [1, 9], "mean": 3}, "normal, mean 3, std 1, between 1 and 9"),
        ({"shape": 2, "scale": 7}, "Weibull, scale 7, shape 2"),
    ],
)
def test_a_distribution_is_told_from_low_to_high(entry, told):
    """Files of a results folder have their entries by name."""
    assert distribution_told("flow.gap", entry).startswith(told)


def test_the_page_says_how_it_was_computed(tmp_path):
    collected = with_errors(made_up(tmp_path, GRID, NUMBERS, failed={5}))
    _, words = read(render_sweep(collected, COMPUTED))
    assert "Of 6 results of the stage flow, 2 started from cold and 4 from that of a" in words
    # The contact point is off by a hundredth of the gap [mm]: most in the case before the failed.
    assert re.search(r"Contact point 0\.040 −3 mm 5\. gap 4 mm", words)
    assert "flow 6 60.0 80.5" in words
    # From before it was recorded: no processor time.
    assert "cell 1 – 2.0" in words
    assert "all else, by case 5 1.5 2.5" in words
    assert "together 61.5 85.0" in words
    assert "the last run into the folder took 42 s and found 1 stage there" in words
    assert "ngsolve 6.2.1, 6.2.2" in words
    assert "How it was computed" not in read(render_sweep(collected))[1]


MODELS = f'{GRID}\n"fiber.model" = ["spheroid", "confined-ellipse"]'
ONE_MODEL = '[fiber]\nmodel = "spheroid"\n'


@pytest.mark.parametrize(
    ("table", "there"), [(MODELS, True), (f"{GRID}\n{ONE_MODEL}", False), (GRID, True)]
)
def test_sources_are_those_of_any_case(tmp_path, table, there):
    """Only the fiber in its cell is solved for by finite elements; half of the cases have one."""
    reader, _ = read(render_sweep(made_up(tmp_path, table, NUMBERS)))
    assert ("source-zhang2011" in reader.names) == there
    assert reader.names.count("source-awenlimobor2024") == 1


@pytest.mark.parametrize("design", [GRID, ONE_AT_A_TIME, sampled("sobol", 4)])
def test_every_design_has_sources(tmp_path, design):
    _, words = read(render_sweep(made_up(tmp_path, design, NUMBERS), COMPUTED))
    assert "Array programming with NumPy" in words


@pytest.mark.parametrize(
    ("table", "keys"),
    [
        (sampled("saltelli", 16), ["hyndman1996", "sobol2001", "saltelli2010", "herman2017"]),
        (
            sampled("latin-hypercube", 8),
            ["hyndman1996", "sobol2001", "plischke2010", "tissot2012", "herman2017"],
        ),
        (
            '"fiber.aspect_ratio" = { scale = 6, shape = 2, between = [1, 30] }\n'
            'design = "latin-hypercube"\nsamples = 8\n',
            ["hyndman1996", "fu1996"],
        ),
        (GRID, []),
    ],
)
def test_samples_bring_the_sources_of_what_is_made_of_them(tmp_path, table, keys):
    collected = made_up(tmp_path, table, {})
    found = sources_told(collected, sweep_table(collected))
    listed = re.findall(r'<li id="source-(\w+)">', found)
    own = ("hyndman1996", *(key for uses in INDEX_USES.values() for key, _ in uses), "fu1996")
    assert [key for key in listed if key in own] == keys
    assert listed[0] == "awenlimobor2024"


def with_melt(collected, names, kelvin):
    """Return a sweep whose cases have voids in melts of some names and temperatures [K]."""
    over = collected["status"]
    keys = [name.lower() for name in names]
    return collected.assign(
        void_material_name=over.copy(data=np.array(names, dtype=object).reshape(over.shape)),
        void_material=over.copy(data=np.array(keys, dtype=object).reshape(over.shape)),
        void_temperature=over.copy(data=np.reshape(kelvin, over.shape)),
    )


@pytest.mark.parametrize(
    ("names", "kelvin", "told"),
    [
        (["ABS"] * 6, [503.15] * 6, "ABS (melt.material = abs) at 230°C"),
        (["ABS"] * 5 + [""], [503.15] * 5 + [np.nan], "ABS (melt.material = abs) at 230°C"),
        (
            ["PLA", "ABS"] * 3,
            [483.15, 503.15] * 3,
            "PLA (melt.material = pla) or ABS (melt.material = abs) at 210 to 230°C",
        ),
    ],
)
def test_the_melt_of_the_voids_is_told(tmp_path, names, kelvin, told):
    collected = with_melt(made_up(tmp_path, GRID, NUMBERS), names, kelvin)
    text = re.sub("<[^>]*>", "", varied_told(collected, sweep_table(collected)))
    assert f"Voids are those of {told}." in text.replace("\N{NO-BREAK SPACE}", "")


def test_without_voids_no_melt_is_told(tmp_path):
    collected = made_up(tmp_path, GRID, NUMBERS)
    assert "Voids are" not in varied_told(collected, sweep_table(collected))
    nothing = with_melt(collected, [""] * 6, [np.nan] * 6)
    assert "Voids are" not in varied_told(nothing, sweep_table(nothing))
