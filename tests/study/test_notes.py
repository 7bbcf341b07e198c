"""What is told of a study that is allowed, and perhaps not meant."""

from __future__ import annotations

import pytest

from fibermelt.study.loading import resolve


def notes(**tables: dict[str, object]) -> str:
    return "\n".join(resolve(tables).notes())


def test_the_papers_study_has_nothing_to_tell() -> None:
    assert notes() == ""


@pytest.mark.parametrize(
    ("tables", "told"),
    [
        ({"flow": {"gap": "0.8 mm", "inlet_speed": "6 mm/s"}}, "0.1 of the gap (flow.gap)"),
        (
            {"flow": {"gap": "0.2 mm", "inlet_speed": "1.6 mm/s"}},
            "0.42 of the gap (flow.gap), 0.42 of the bead",
        ),
        ({"fiber": {"half_length": "0.3 mm"}}, "0.19 of the capillary (flow.capillary_width)"),
    ],
)
def test_a_fiber_that_is_not_small_is_told(tables: dict[str, dict[str, object]], told: str) -> None:
    assert told in notes(**tables)


@pytest.mark.parametrize(
    ("gap", "told"),
    [
        ("2.48 mm", "the gap is 0.827 times the bead's height of 3 mm: below 0.83 the melt climbs"),
        ("2.5 mm", ""),
        ("4.7 mm", ""),
        ("4.9 mm", "the gap is 1.63 times the bead's height of 3 mm: above 1.6"),
    ],
)
def test_a_gap_without_a_steady_bead_is_told(gap: str, told: str) -> None:
    assert notes(flow={"gap": gap}).startswith(told)
    assert bool(notes(flow={"gap": gap})) == bool(told)


def test_a_melt_with_inertia_is_told_its_reynolds_number() -> None:
    # 1154 kg/m3 at 0.3048e-3 m2/s over 1 mPa s
    assert "Reynolds number of the capillary is 3.5e+02" in notes(melt={"viscosity": "1 mPa s"})
    assert "Reynolds" not in notes(melt={"viscosity": "40 Pa s"})
