"""The report's sections: each number is the stored one, and none is told that is not stored."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest
import xarray as xr
from markupsafe import Markup, escape
from stored_bead import stored_results, stored_summary
from suspended_fibers import interacting, oriented
from turned_fibers import compared, turned

from fibermelt.paper.claims.section import claims
from fibermelt.paper.dimensions.section import dimensions
from fibermelt.paper.dimensions.summary import summarize_dimensions
from fibermelt.paper.orbits.section import shear
from fibermelt.paper.orbits.summary import summarize_orbits
from fibermelt.parts.bead.section import numbers
from fibermelt.parts.bead.summary import bead_in_words
from fibermelt.parts.interaction.section import content
from fibermelt.parts.interaction.summary import summarize_interaction
from fibermelt.parts.orientation.section import orientation
from fibermelt.parts.orientation.summary import summarize_orientation
from fibermelt.parts.verification.section import verification
from fibermelt.parts.voids.answer import LABELS
from fibermelt.parts.voids.figures.where import figure_voids
from fibermelt.parts.voids.section import voids
from fibermelt.parts.voids.summary import summarize_voids, voids_in_words
from fibermelt.report.kit.tables import fixed, number, percent, short, sized
from fibermelt.report.page.answer import answer
from fibermelt.report.page.embed import Embedded
from fibermelt.report.page.figures import FIGURES
from fibermelt.report.page.sections import SECTIONS, filled

MPA = 1e-6


def rows(html: str, caption: str) -> list[list[str]]:
    """Return the cells of a table's body as a reader sees them."""
    start = html.index(f"<caption><span>{caption}")
    body = html[html.index("<tbody>", start) : html.index("</tbody>", start)]
    return [
        [re.sub(r"<[^>]+>", " ", cell).strip() for cell in re.findall(r"<t[hd].*?>(.*?)</t", row)]
        for row in re.findall(r"<tr>(.*?)</tr>", body, re.S)
    ]


@pytest.fixture(scope="module")
def orbits() -> dict[str, Any]:
    return summarize_orbits(turned())


def test_table_1_stands_with_ours_and_the_papers_beside_jefferys(orbits: dict[str, Any]) -> None:
    html = shear.words(xr.Dataset(), orbits)
    for sweep, what in (("aspect_ratio", "aspect ratio"), ("shear_rate", "shear rate")):
        stored = [row for row in orbits["orbits"]["periods"] if row["sweep"] == sweep]
        assert len(stored) == 3
        for shown, row in zip(rows(html, f"Time of a full turn by {what}"), stored, strict=True):
            assert shown == [
                short(row[sweep]),
                fixed(row["jeffery"], 2),
                fixed(row["ours"], 2),
                percent(row["ours_above_jeffery"]),
                fixed(row["paper"], 2),
                percent(row["paper_above_jeffery"]),
            ]
    assert "M = 28" in html
    lows = rows(html, "Lowest pressure on the fiber’s surface")
    cases = [case for case in orbits["orbits"]["cases"] if case["sweep"] != "base"]
    assert [row[3] for row in lows] == [
        number(1e-3 * case["confined-ellipse"]["min_pressure"]) for case in cases
    ]


def test_how_much_the_cell_is_felt_follows_the_numbers(orbits: dict[str, Any]) -> None:
    """Every cell was told to be far enough to matter little, also one that stalls the fiber."""
    changed = copy.deepcopy(orbits)
    base = changed["orbits"]["cases"][0]
    base["confined-ellipse"]["period"] = 1.25 * base["ellipse"]["period"]
    html = shear.words(xr.Dataset(), changed)
    assert "a turn takes 125.0 % of the time that Jeffery’s takes" in html
    base["confined-ellipse"]["period"] = None
    assert "so near that the fiber stalls in it" in shear.words(xr.Dataset(), changed)


def test_a_fiber_that_stalls_has_no_period(orbits: dict[str, Any]) -> None:
    stalled = copy.deepcopy(orbits)
    row = stalled["orbits"]["periods"][0]
    row["ours"] = row["ours_above_jeffery"] = row["paper"] = row["paper_above_jeffery"] = None
    shown = rows(shear.words(xr.Dataset(), stalled), "Time of a full turn by aspect ratio")[0]
    assert shown[2:] == ["–"] * 4


def test_two_dimensions_stand_against_three() -> None:
    summary = summarize_dimensions(compared())
    found = summary["dimensions"]
    html = dimensions.words(xr.Dataset(), summary)
    peaks = rows(html, "Highest pressure in simple shear")
    assert [row[-1] for row in peaks] == [
        number(peak["spheroid_over_ellipse"]) for peak in found["peaks"]
    ]
    along = rows(html, "Lowest surface pressure along streamlines")
    assert [row[:2] for row in along] == [[k, at] for k in ("4", "10", "18") for at in "012"]
    by = {(row["streamline"], row["location"], row["model"]): row for row in found["streamlines"]}
    for row in along:
        spheroid = by[int(row[0]), int(row[1]), "spheroid"]
        assert row[-2:] == [fixed(MPA * spheroid[key], 3) for key in ("lowest", "bound")]


@pytest.fixture(scope="module")
def suspension() -> xr.Dataset:
    return interacting()


def test_content_leads_to_the_cell_by_both_conventions(suspension: xr.Dataset) -> None:
    results = suspension
    summary = summarize_interaction(results)
    found = summary["interaction"]
    html = content.words(results, summary)
    told = {row[0]: row[1] for row in rows(html, "The study’s content")}
    assert told["Interaction coefficient C_I"] == number(found["interaction"])
    assert told["Domain size M in which a fiber stalls at it"] == number(found["domain_size"])
    off = rows(html, "Largest difference from the computed curves")
    assert off[0][1:3] == [number(found["difference_from_eq_32"])] * 2
    assert off[2][1:3] == [
        number(found["difference_from_eq_34"][name]) for name in ("standard", "paper")
    ]
    curves = rows(html, "Preferred angle and domain size by convention")
    sizes = results["interaction_domain_size"].sel(convention="paper").to_numpy()
    assert [row[-1] for row in curves] == [fixed(size, 3) for size in sizes]


def test_a_closure_that_is_not_compared_has_no_angles(suspension: xr.Dataset) -> None:
    results = suspension
    other = results.assign(interaction_closure="ORL")
    assert "Angle, standard" in content.words(results, summarize_interaction(results))
    assert "Angle, standard" not in content.words(other, summarize_interaction(results))


def test_the_tensor_at_the_outlet_is_told_by_streamline() -> None:
    results = oriented(count=6)
    html = orientation.words(results, summarize_orientation(results))
    shown = rows(html, "Orientation tensor at the outlet")
    last = results["orientation"].to_numpy()[:, -1]
    for row, tensor in zip(shown, last, strict=True):
        assert row[1:5] == [fixed(tensor[i, j], 3) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1))]
        # The principal axis in the plane, by another way.
        axis = np.linalg.eigh(tensor[:2, :2])[1][:, -1]
        assert float(row[5].replace("−", "-")) == pytest.approx(
            np.degrees(np.arctan(axis[1] / axis[0])), abs=0.0501
        )
    near = results["near_singularity"].to_numpy().astype(bool)
    assert ["*" in row[0] for row in shown] == near.tolist()
    assert fixed(float(results["closure_error"].max()), 3) in html
    left = results.assign(orientation_violation=("streamline", np.full(6, 0.25)))
    assert "by up to 0.25" in orientation.words(left, summarize_orientation(left))


@pytest.fixture(scope="module")
def bead() -> xr.Dataset:
    return stored_results()


@pytest.fixture(scope="module")
def risk(bead: xr.Dataset) -> dict[str, Any]:
    return {**stored_summary(bead), **summarize_voids(bead)}


def largest(rows: Iterable[dict[str, Any]], *names: str) -> float:
    return max(abs(row[name]) for row in rows for name in names if row[name] is not None)


def test_where_it_can_void_is_told_as_it_is_stored(bead: xr.Dataset, risk: dict[str, Any]) -> None:
    found = risk["voids"]
    html = voids.words(bead, risk)
    assert f"{number(MPA * found['vapor_pressure'], 3)} MPa" in html
    most = largest(found["by_basis"].values(), "lowest_pressure", "margin")
    by_basis = rows(html, "Lowest local pressure in the bead")
    assert [row[1] for row in by_basis] == [
        sized(MPA * one["lowest_pressure"], MPA * most, 4) for one in found["by_basis"].values()
    ]
    profile = rows(html, "From the free surface down to the bed")
    heights = [float(row[0]) for row in profile]
    assert heights == sorted(heights, reverse=True)
    bottom = found["profile"][0]["fiber_pressure"]
    most = largest(found["profile"], "fiber_pressure", "mean_pressure", "lowest_pressure")
    assert profile[-1][1] == ("–" if bottom is None else sized(MPA * bottom, MPA * most, 4))
    lines = rows(html, "Each streamline, any direction of a fiber")
    most = largest(found["streamlines"], "lowest_pressure")
    assert [row[2] for row in lines] == [
        sized(MPA * line["lowest_pressure"], MPA * most, 4) for line in found["streamlines"]
    ]
    for assumed in (*found["material"]["estimates"], *found["material"]["missing"]):
        assert assumed in html


def test_numbers_of_a_flow_from_elsewhere_name_no_capillary(bead: xr.Dataset) -> None:
    summary = stored_summary(bead)
    assert "Loc. 1 lies before the capillary, Loc. 2 between" in numbers.words(bead, summary)
    whole = [one for one in summary["extremes"] if one["location"] == 0]
    html = numbers.words(bead, {**summary, "flow": {}, "extremes": whole})
    assert "capillary" not in html
    assert "The flow" not in html
    assert "Loc. 0 is the whole way" in html


def test_what_was_assumed_of_a_file_is_told(bead: xr.Dataset) -> None:
    summary = stored_summary(bead.assign(field_notes="lengths in m are assumed\na trace"))
    assert summary["field"] == {"notes": ["lengths in m are assumed", "a trace"]}
    assert "as read         lengths in m are assumed" in bead_in_words(summary)
    assert "lengths in m are assumed" in answer(bead, summary)
    assert "field" not in stored_summary(bead.assign())


def told_of(summary: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """Return what is stored of voids, changed."""
    return {**copy.deepcopy(summary["voids"]), **changes}


def test_page_terminal_and_summary_give_the_same_answers(
    bead: xr.Dataset, risk: dict[str, Any]
) -> None:
    """One statement, one place: each answer of the summary stands on both, word for word.

    On the page numbers stay with their units.
    """
    html, words = answer(bead, risk), voids_in_words(risk)
    assert risk["voids"]["answer"]
    for one in risk["voids"]["answer"]:
        assert one["question"] in html
        assert str(escape(one["answer"])) in html.replace("\u00a0", " ")
        assert f"{LABELS[one['question']]:<15} {one['answer']}" in words


@pytest.mark.parametrize(
    ("rate", "threshold", "outcome"),
    [(-3.0, 0.0, "none starts"), (-3.0, -6.0, "bubbles start"), (4.0, 6.0, "none starts")],
)
def test_what_counts_as_onset_is_what_the_study_says(
    bead: xr.Dataset, risk: dict[str, Any], rate: float, threshold: float, outcome: str
) -> None:
    found = told_of(risk, threshold_rate=10.0**threshold)
    for line in found["streamlines"]:
        line.update(log10_rate=rate, critical_radius=4e-9, required_wetting=0.5)
    html = voids.words(bead.assign(void_threshold=threshold), {**risk, "voids": found})
    assert f"counted as onset is {number(threshold, 3)}: {outcome}." in html
    assert ("50 % of the barrier" in html) == (outcome == "none starts")
    (line,) = [one for one in voids_in_words({"voids": found}) if one.startswith("nucleation")]
    assert f"{threshold:g} counts as onset" in line
    assert ("bubbles start" in line) == (outcome == "bubbles start")
    assert ("50 % of the barrier" in line) == (outcome == "none starts")


def test_without_moisture_the_answer_keeps_to_the_pressures(bead: xr.Dataset) -> None:
    html = answer(bead, stored_summary(bead))
    regular = bead.isel(streamline=np.flatnonzero(bead["near_singularity"].to_numpy() == 0))
    lowest = float((regular["pressure"] + regular["bound_lowest"]).min())
    assert f"{number(MPA * abs(lowest), 3)} MPa {'below' if lowest < 0 else 'above'}" in html
    assert "Not judged, as no moisture was told" in html
    alone = answer(bead.assign(near_singularity=bead["near_singularity"] * 0 + 1), {"cost": {}})
    assert "Can it void?" not in alone
    assert "No bead: " in alone


def test_without_a_bead_the_answer_is_of_a_fiber(
    bead: xr.Dataset, orbits: dict[str, Any], suspension: xr.Dataset
) -> None:
    summary = {**orbits, **summarize_interaction(suspension)}
    html = answer(xr.Dataset(attrs=bead.attrs), summary)
    base = orbits["orbits"]["cases"][0]
    assert f"turns in {number(base['confined-ellipse']['period'])} s in its cell" in html
    assert f"{number(1e-3 * base['ellipse']['min_pressure'])} kPa without" in html
    assert f"M = {fixed(summary['interaction']['domain_size'], 3)}" in html


CLAIM = {"statement": "s", "paper": "1", "ours": "2", "reason": "why", "measure": "what of it"}


def test_claims_are_counted_by_section_of_the_paper(bead: xr.Dataset) -> None:
    listed = [
        {**CLAIM, "id": "a", "section": "2.3, Table 1", "verdict": "holds"},
        {**CLAIM, "id": "b", "section": "2.3, Fig. 8-9, and 4", "verdict": "differs"},
        {**CLAIM, "id": "c", "section": "3 and 4", "verdict": "cannot be judged"},
    ]
    html = claims.words(xr.Dataset(), {"claims": listed})
    assert rows(html, "Verdicts") == [
        ["Section 2.3, one fiber in simple shear", "1", "1", "0", "2"],
        ["Section 3, fibers in the bead", "0", "0", "1", "1"],
        ["In all", "1", "1", "1", "3"],
    ]
    assert len(rows(html, "Section 2.3, one fiber")) == 2
    assert html.count('type="radio"') == 4
    assert html.count('checked=""') == 1
    assert "what of it" in html
    # One statement may be tested in several ways.
    listed[0]["statement"] = "another"
    words = "3 tests of 2 statements of the paper"
    summary = {**stored_summary(bead), "claims": listed}
    assert f"<p>{words}, judged by code" in claims.words(xr.Dataset(), summary)
    assert f"Of {words}: holds 1, differs 1, cannot be judged 1 (" in answer(bead, summary)


CHECKS: dict[str, Any] = {
    "name": ["Couette", "cell"],
    "subject": ["flow", "fiber"],
    "what": ["drag against exact", "spin"],
    "reference": ["exact", ""],
    "value": [3.2e-9, np.nan],
    "lowest": [0.0, 1.8],
    "highest": [1e-8, 2.2],
    "unit": ["Pa", ""],
    "passed": np.array([1, 0], dtype=np.int8),
}


def test_checks_are_told_where_they_are_stored() -> None:
    stored = xr.Dataset({f"check_{name}": ("check", list(CHECKS[name])) for name in CHECKS})
    html = verification.words(stored, {})
    assert "1 of 2 checks pass" in html
    assert rows(html, "Flow")[0][1:] == ["3.20 × 10⁻⁹ Pa", "at most 1.00 × 10⁻⁸ Pa", "✓ pass"]
    assert rows(html, "Fiber")[0][1:] == ["–", "1.80 to 2.20", "✗ fail"]
    more = {"check_failure": ("check", ["", "it did not converge"]), "check_software": "scipy 1"}
    html = verification.words(stored.assign(more), {})
    assert "it did not converge" in rows(html, "Fiber")[0][0]
    assert "with scipy 1" in html


def embedded(name: str, section: str) -> Embedded:
    return Embedded(name, name, section, "", "caption", "alt", Markup("data:,"), Markup(), 10, 10)


def test_each_figure_stands_in_the_section_that_it_names(bead: xr.Dataset) -> None:
    figures = [embedded(plate.name, plate.section) for plate in FIGURES]
    found = filled(bead, stored_summary(bead), figures)
    assert [figure for one in found for figure in one.figures] == figures
    order = [section.name for section in SECTIONS]
    assert [one.section.name for one in found] == [
        name for name in order if name in {one.section.name for one in found}
    ]


def test_what_is_not_stored_is_left_out(bead: xr.Dataset) -> None:
    found = {one.section.name for one in filled(bead, stored_summary(bead, claims=False), [])}
    assert found == {"numbers", "files", "cost", "versions", "sources"}


def test_one_streamline_is_one(bead: xr.Dataset, risk: dict[str, Any]) -> None:
    assert "on 1 streamline." in answer(bead, {**risk, "streamlines": risk["streamlines"][:1]})
    assert "the 0 streamlines" not in figure_voids.words(bead.assign(near_singularity=0)).caption
