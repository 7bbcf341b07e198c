"""The report's page: pure, whole in one file, readable without eyes, and nothing unescaped."""

from __future__ import annotations

import base64
import io
import json
import re
import tomllib
from html.parser import HTMLParser
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from drawn_cases import case
from numpy.typing import NDArray
from PIL import Image
from stored_bead import stored_results, stored_summary

from fibermelt.engine.parameters import Declaration, declarations, flatten
from fibermelt.errors import StoreError
from fibermelt.paper.claims.section import claims
from fibermelt.parts.bead.figures.interactive import MOST_ANGLES, MOST_LINES, moving_data
from fibermelt.report.kit.tables import Column, Table, measured, number
from fibermelt.report.page import embed
from fibermelt.report.page.embed import _in_dots, embed_figures
from fibermelt.report.page.endmatter import files
from fibermelt.report.page.figures import FIGURES, draw_figures
from fibermelt.report.page.page import render
from fibermelt.report.page.sections import SECTIONS
from fibermelt.report.page.sources import USES, read_sources, sources_of, written
from fibermelt.report.page.what_was_run import _one, what_was_run
from fibermelt.study.config import Config
from fibermelt.study.loading import resolve
from fibermelt.units import parse

LARGEST = 5_000_000
"""Bytes that a report may have."""

VOID = {"meta", "link", "img", "br", "input"}


class Reader(HTMLParser):
    """Reads a page and refuses tags that do not match; keeps what the tests ask for."""

    def __init__(self, page: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: dict[str, list[str]] = {}
        self.feed(page)
        self.close()
        assert not self.open

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert len({name for name, _ in attrs}) == len(attrs), f"{tag}: {attrs}"
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open:
            self.text.setdefault(self.open[-1], []).append(data)

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return stored_results()


@pytest.fixture(scope="module")
def drawn(results: xr.Dataset, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("figures")
    return {path.name: path.read_bytes() for path in draw_figures(results, folder)}


@pytest.fixture(scope="module")
def page(results: xr.Dataset, drawn: dict[str, bytes]) -> str:
    return render(results, stored_summary(results), drawn).decode()


@pytest.fixture(scope="module")
def read(page: str) -> Reader:
    return Reader(page)


def test_the_same_store_gives_the_same_bytes_drawn_before_or_not_whatever_the_users_settings(
    page: str, results: xr.Dataset
) -> None:
    before = results.copy(deep=True)
    mine = {"font.size": 20, "svg.hashsalt": "mine", "lines.linewidth": 20}
    with mpl.rc_context(mine):
        assert render(results, stored_summary(results)) == page.encode()
        assert mpl.rcParams["font.size"] == 20
    xr.testing.assert_identical(results, before)


def test_it_is_small(page: str) -> None:
    assert len(page.encode()) < LARGEST


def test_it_refers_to_nothing_outside(page: str, read: Reader) -> None:
    for tag, attributes in read.tags:
        for name, value in attributes.items():
            assert value is not None or name in {"hidden"}
            if re.search(r"https?://", value or ""):
                assert (tag, name) == ("a", "href")
            if name == "src" or (tag, name) == ("link", "href"):
                assert str(value).startswith("data:")
    assert "http" not in re.sub(r'"http:" \+ "//www\.w3\.org', "", "".join(read.text["script"]))
    style = "".join(read.text["style"])
    assert "url(" not in style
    assert "@import" not in style
    policy = next(meta for meta in read.all("meta") if "http-equiv" in meta)["content"]
    assert "default-src 'none'" in str(policy)


def test_what_lies_beside_it_is_a_click_away(page: str, results: xr.Dataset) -> None:
    for name in ("results.nc", "summary.json", "config.toml", "flow.vtu", "export/"):
        assert f'<a href="{name}">{name}</a>' in page
    alone = results.assign_attrs(config='study.parts = ["orientation"]')
    assert "flow.vtu" not in files.words(alone, {})  # no other part writes one
    study = 'flow.source = "field"\nfield.file = "a.vtu"\nfield.content = "known"'
    assert "flow.vtu" not in files.words(results.assign_attrs(config=study), {})


def test_figures_stand_once_each_with_words_and_a_size(read: Reader, results: xr.Dataset) -> None:
    images = read.all("img")
    drawn = [plate for plate in FIGURES if plate.is_of(results)]
    words = {plate.name: plate.words(results).alt for plate in drawn}
    assert [image["alt"] for image in images] == list(words.values())
    assert len({image["src"] for image in images}) == len(drawn)
    for image in images:
        assert int(str(image["width"])) > 1000
        assert int(str(image["height"])) > 300


def test_headings_are_in_order(read: Reader) -> None:
    levels = [int(tag[1]) for tag, _ in read.tags if re.fullmatch(r"h[1-6]", tag)]
    assert levels.count(1) == 1
    assert levels[0] == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))


def test_ids_are_unique_and_every_link_within_arrives(read: Reader) -> None:
    ids = [attributes["id"] for _, attributes in read.tags if "id" in attributes]
    assert len(set(ids)) == len(ids)
    names = {"for", "aria-labelledby"}
    wanted = {value for _, found in read.tags for name, value in found.items() if name in names}
    wanted |= {str(a["href"])[1:] for a in read.all("a") if str(a["href"]).startswith("#")}
    assert wanted <= set(ids)


def test_landmarks_tables_and_controls_are_named(read: Reader) -> None:
    for landmark in ("header", "nav", "main", "footer"):
        assert len(read.all(landmark)) == 1
    assert len(read.all("caption")) == len(read.all("table")) > 0
    assert all(cell.get("scope") in {"row", "col"} for cell in read.all("th"))
    labelled = {label["for"] for label in read.all("label")}
    controls = read.all("input") + read.all("select")
    # Streamline, fiber and time of the moving figure; three choices of verdicts.
    assert len(controls) == 6
    assert {control["id"] for control in controls} <= labelled
    assert read.tags[[tag for tag, _ in read.tags].index("a")][1]["class"] == "skip"


MARKUP = '<img src=x onerror="alert(1)">&</script>'


def test_markup_in_a_store_is_text(drawn: dict[str, bytes]) -> None:
    results = stored_results(name=MARKUP)
    summary = stored_summary(results)
    hostile = dict.fromkeys(("id", "section", "statement", "paper", "ours", "reason"), MARKUP)
    summary["claims"] = [{**hostile, "verdict": MARKUP}]
    summary["cost"] = {MARKUP: 1.0}
    results.attrs["software"] = json.dumps({MARKUP: MARKUP})
    page = render(results, summary, drawn).decode()
    assert "<img src=x" not in page
    read = Reader(page)
    assert MARKUP in "".join(read.text["h1"])
    assert len(read.all("img")) == len([plate for plate in FIGURES if plate.is_of(results)])


def test_sections_are_left_out_where_there_is_nothing_to_tell(results: xr.Dataset) -> None:
    bare = results.drop_vars([*results.variables]).assign_attrs(results.attrs)
    read = Reader(render(bare, {"schema": 1, "cost": {"orbits": 1.0}}).decode())
    sections = [section["id"] for section in read.all("section")]
    assert sections == ["run", "files", "cost", "versions", "sources"]
    assert not read.all("script")
    assert not read.all("img")


def test_claims_are_told_with_their_verdicts(results: xr.Dataset) -> None:
    html = claims.words(results, stored_summary(results))
    for text in ("holds 1, differs 1", "✓ holds", "≠ differs", "−0.39", "by 0.11 MPa"):
        assert text in html
    assert not claims.words(results, {"claims": []})


def test_sections_have_names_of_their_own() -> None:
    names = [section.name for section in SECTIONS]
    assert len({*names, "run"}) == len(names) + 1
    assert len({section.place for section in SECTIONS}) == len(names)


def test_parameters_are_in_the_units_of_their_defaults_and_marked(results: xr.Dataset) -> None:
    assert "All parameters have their defaults" in what_was_run(results)
    changed = resolve({"flow": {"gap": "3.5 mm"}, "fiber": {"initial_angles": ["10 deg"]}})
    html = what_was_run(stored_results(config=changed))
    assert "2 of its parameters differ from the defaults" in html
    for text in (
        "3.5\xa0mm",
        "default 3\xa0mm",
        "10°",
        "42\xa0µm",
        "101.6\xa0mm/s",
    ):
        assert text in html, text
    assert html.count(">set<") == 2


def test_results_without_a_study_are_refused(results: xr.Dataset) -> None:
    for config in ("[flow]\ngapp = 1", "not TOML"):
        with pytest.raises(StoreError, match="holds no study that this fibermelt reads"):
            render(results.assign_attrs(config=config), {})


def test_the_moving_figure_shows_what_is_stored(results: xr.Dataset) -> None:
    data = json.loads(moving_data(results))
    assert [line["n"] for line in data["lines"]] == list(range(1, 7))
    for row, line in enumerate(data["lines"]):
        for k, fiber in enumerate(line["fibers"]):
            # Kilopascals are whole numbers: half of one is rounding's.
            assert min(fiber["low"]) == pytest.approx(
                1e-3 * float(results["lowest"][row, k].min()), abs=0.5
            )
            # So is the lowest above the air's, which may lie elsewhere.
            local = results["lowest"][row, k] + results["pressure"][row]
            told = np.array(fiber["low"]) + np.array(line["p"])
            assert min(told) == pytest.approx(1e-3 * float(local.min()), abs=1.0)
        assert line["t"][-1] == pytest.approx(1e4 * float(results["time"][row, -1]), abs=0.5)
        assert len(line["t"]) == len(line["fibers"][0]["a"]) == len(line["x"])
        assert all(later > sooner for sooner, later in pairwise(line["t"]))


def test_the_moving_figure_stays_small_with_many_lines_and_fibers() -> None:
    data = json.loads(moving_data(stored_results(count=70, angles=40)))
    # The three marked streamlines are there whatever the others are.
    assert MOST_LINES <= len(data["lines"]) <= MOST_LINES + 3
    assert len(data["starts"]) == MOST_ANGLES
    assert set(data["marked"]) <= {str(line["n"]) for line in data["lines"]}
    one = json.loads(moving_data(stored_results(count=1, angles=1)))
    assert (len(one["lines"]), one["picked"]) == (1, 0)


def test_the_moving_figure_shows_paths_of_any_flow() -> None:
    results = case("paths in space")
    data = json.loads(moving_data(results))
    for row, line in enumerate(data["lines"]):
        ends = [float(results[name][row, -1]) / data["steps"]["length"] for name in "xyz"]
        assert [line[name][-1] for name in "xyz"] == pytest.approx(ends, abs=0.5)
        assert line["zones"] == []
    assert data["scene"] == {"edges": []}
    small = json.loads(moving_data(results.assign({n: 1e-3 * results[n] for n in "xyz"})))
    assert small["steps"]["length"] == pytest.approx(1e-3 * data["steps"]["length"])
    assert small["lines"][0]["z"] == data["lines"][0]["z"]
    corners = np.array([[0.0, 0.0, 0.0], [2e-3, 0.0, 0.0], [0.0, 2e-3, 0.0], [0.0, 0.0, 2e-3]])
    body = results.assign(
        field_points=(("field_node", "space"), corners),
        field_cells=(("field_cell", "field_corner"), [[0, 1, 2, 3]]),
    )
    edges = json.loads(moving_data(body))["scene"]["edges"]
    assert len(edges) == 6  # of a tetrahedron, all sharp
    assert {tuple(end) for edge in edges for end in edge} == {*map(tuple, (1e3 * corners).tolist())}
    assert "z" not in json.loads(moving_data(case("paths from elsewhere")))["lines"][0]


SEEN = 20.0
"""Of 255, over a patch of 8 by 8 dots: a line of another colour would stand out by more."""


def blocks(image: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return means over patches of 8 by 8 dots."""
    high, wide = (8 * (size // 8) for size in image.shape[:2])
    return image[:high, :wide].reshape(high // 8, 8, wide // 8, 8, 3).mean(axis=(1, 3))


def test_figures_go_over_to_dots_where_lines_are_too_large(
    results: xr.Dataset, drawn: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = {found.name: found.source for found in embed_figures(results, drawn)}
    assert all(source.startswith("data:image/svg+xml,") for source in lines.values())
    total = sum(map(len, lines.values()))
    monkeypatch.setattr(embed, "FIGURE_BUDGET", total - 1)
    found = {found.name: found.source for found in embed_figures(results, drawn)}
    changed = [name for name, source in found.items() if source != lines[name]]
    smaller = [
        name for name in lines if _in_dots(drawn[f"{name}.png"], len(lines[name])) is not None
    ]
    assert changed == [max(smaller, key=lambda name: len(lines[name]))]
    assert sum(map(len, found.values())) < total
    kind, _, data = found[changed[0]].partition(",")
    assert kind == "data:image/webp;base64"
    seen, meant = (
        np.asarray(Image.open(io.BytesIO(image)).convert("RGB"), dtype=float)
        for image in (base64.b64decode(data), drawn[f"{changed[0]}.png"])
    )
    assert seen.shape == meant.shape
    assert np.abs(blocks(seen - meant)).max() < SEEN


def test_every_use_has_a_source_that_is_whole() -> None:
    every = read_sources()
    assert {use.key for use in USES} <= set(every)
    for key, source in every.items():
        assert {"author", "title", "year"} <= set(source.fields), key
        assert "journal" in source.fields or "school" in source.fields, key
        assert source.fields["year"] in key
        assert re.fullmatch(r"10\.\d{4,}/\S+", source.fields.get("doi", "10.1000/none")), key
        assert source.fields["author"].split(",")[0] in written(source)


def test_sources_follow_what_ran() -> None:
    def keys(**tables: dict[str, object]) -> set[str]:
        return {source.key for source, _ in sources_of(flatten(resolve(tables)))}

    assert "jeffery1922" not in keys()
    assert "zhang2011" in keys()
    assert "jeffery1922" in keys(fiber={"model": "spheroid"})
    assert "zhang2011" not in keys(fiber={"model": "spheroid"})
    assert "jeffery1922" in keys(study={"parts": ["orbits"]})
    assert not {"folgar1984", "verweyst1998", "wagner2000"} & keys()
    assert {"folgar1984", "verweyst1998", "bay1991"} <= keys(fiber={"domain_size": "from-content"})
    other = keys(
        study={"parts": ["bead", "orientation"]},
        interaction={"closure": "ORF", "law": "phan-thien"},
    )
    assert {"cintra1995", "phanthien2002", "montgomerysmith2010"} <= other
    assert not {"verweyst1998", "bay1991", "wang2008"} & other
    assert {"wang2008", "phelps2009"} <= keys(
        study={"parts": ["bead", "orientation"]}, interaction={"model": "ard-rsc", "b1": 1e-3}
    )
    given = keys(study={"parts": ["interaction"]}, interaction={"coefficient": 0.01})
    assert "bay1991" not in given
    assert {"verweyst1998", "cintra1995", "chung2002", "carlson1979"} <= given
    wet = keys(study={"parts": ["bead", "voids"]})
    assert {"roychowdhury2001", "blander1975", "wagner2000"} <= wet
    assert "sugden1924" not in wet


def test_a_default_study_reads_back() -> None:
    assert resolve(tomllib.loads(stored_results().attrs["config"])) == Config()


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        (float("nan"), "–"),
        (0.0, "0"),
        (33443, "33443"),
        (2.0, "2"),
        (-2.00907, "−2.009"),
        (0.99999, "1.000"),
        (902602.5, "902602"),
        (3.19e-10, "3.190 × 10⁻¹⁰"),
    ],
)
def test_numbers(value: float | None, text: str) -> None:
    assert number(value) == text


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (-2.00907, 0.00086, "−2.00907 ± 0.00086"),
        (0.9026, 0.019, "0.903 ± 0.019"),
        (812.3, 40.0, "812 ± 40"),
        (1.03436, 8.6e-10, "1.03436 ± 8.6 × 10⁻¹⁰"),
        (1.03436, float("nan"), "1.034"),
        (1.03436, 0.0, "1.034"),
    ],
)
def test_numbers_with_an_error(value: float, error: float, text: str) -> None:
    assert measured(value, error) == text


def test_a_table_refuses_rows_of_another_length() -> None:
    with pytest.raises(ValueError, match="2 columns was given a row of 1"):
        Table("caption", [Column("a"), Column("b")], [["1"]])


@pytest.mark.parametrize("item", list(declarations(Config)), ids=lambda item: item.key)
def test_what_is_shown_of_a_parameter_is_its_value(item: Declaration) -> None:
    """230 degC has been shown as 1.8 degC: a scale need not begin at zero."""
    value = flatten(Config())[item.key]
    if isinstance(value, bool) or not isinstance(value, float):
        return
    shown = _one(item, value).replace("\N{NO-BREAK SPACE}", " ").replace("µ", "u")
    shown = shown.replace("°C", " degC").replace("°", " deg").replace("³", "^3")
    shown = shown.replace("−", "-")
    if shown.endswith("%"):
        found = float(shown[:-1]) / 100
    else:
        found = parse(shown, item.unit) if item.unit else float(shown)
    assert found == pytest.approx(value, rel=1e-5)
