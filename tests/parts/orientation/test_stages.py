"""From content to the cell, and tensors along streamlines: the stages do what direct calls do."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any, get_args

import numpy as np
import pytest
import xarray as xr
from suspended_fibers import CELLS, interacting, oriented, parameters, quiet, stalled

from fibermelt.engine.quantities import labelled
from fibermelt.engine.stages import Parameters
from fibermelt.errors import ConfigError
from fibermelt.fiber.shape import jeffery_factor
from fibermelt.fiber.stall_data import StallCurve
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.evolve import follow_orientation
from fibermelt.orientation.flows import FLOWS
from fibermelt.orientation.fokker_planck import follow_distribution, steady_distribution
from fibermelt.orientation.interaction import bay, paper_domain_size, paper_preferred_angle
from fibermelt.orientation.kinetics import CONVENTIONS
from fibermelt.orientation.models import MODELS, FolgarTucker
from fibermelt.orientation.steady import steady_state
from fibermelt.orientation.tensors import isotropic
from fibermelt.parts.bead.stages import cell_stage
from fibermelt.parts.interaction.config import OWN, WITHOUT_COEFFICIENT, Interaction, ModelName
from fibermelt.parts.interaction.models import WRITTEN
from fibermelt.parts.interaction.stages import content_stage, stall_stage, stored_curve
from fibermelt.parts.interaction.suspension import DISTRIBUTION, folgar_tucker, preferred_angle
from fibermelt.parts.orientation.stages import orientation_estimates, orientation_stage
from fibermelt.parts.orientation.summary import stored_model
from fibermelt.study.loading import merged, resolve
from fibermelt.study.quantities import QUANTITIES
from fibermelt.sweeps.axes import Axis
from fibermelt.sweeps.design import Sweep

XI = jeffery_factor(6.0)
C_I = bay(0.084, 6.0)

PAPER_DOMAIN, PAPER_WITHIN = 4.08, 0.1
"""The paper's ``M`` for its fiber content and how near it is asked to be."""

SAME = 1e-13
"""The same numbers by the same steps, in batches of another size: rounding."""

STATE = 1e-10
"""Steady states to a residual of 1e-12 from other starts, over the slowest rate of decay."""


def content(**changes: Any) -> xr.Dataset:
    return content_stage(parameters(**changes), {"stall": stalled()}, quiet)


def tiny(rate: float = 2.0) -> xr.Dataset:
    """Two lines of nine points: simple shear, and shear that turns into planar elongation."""
    time = np.broadcast_to(np.linspace(0.0, 3.0, 9), (2, 9))
    shear, planar = (FLOWS[name][:2, :2] for name in ("simple-shear", "planar"))
    part = np.linspace(0.0, 1.0, 9)[:, None, None]
    gradient = rate * np.stack([np.broadcast_to(shear, (9, 2, 2)), shear + part * planar])
    return labelled(
        {
            "streamline": np.array([3, 7]),
            "flux_fraction": np.array([0.4, 0.8]),
            "time": time,
            "gradient": gradient,
        },
        QUANTITIES,
    )


@pytest.mark.parametrize(("convention", "factor"), [("standard", 1.0), ("paper", np.sqrt(2.0))])
@pytest.mark.parametrize("start", ["isotropic", "inlet"])
def test_tensors_along_streamlines_are_those_of_direct_calls(
    start: str, convention: str, factor: float
) -> None:
    lines = tiny()
    found = orientation_stage(
        parameters(start=start, convention=convention), {"streamlines": lines}, quiet
    )
    time, gradient = lines["time"].to_numpy(), lines["gradient"].to_numpy()
    model, closure = FolgarTucker(XI, factor * C_I), CLOSURES["ORE"]
    first = [steady_state(model, L, closure).a for L in gradient[:, 0]]
    a0 = np.broadcast_to(isotropic(), (2, 3, 3)) if start == "isotropic" else np.stack(first)
    direct = follow_orientation(model, closure, (time, gradient), a0)
    np.testing.assert_allclose(found["orientation"].to_numpy(), direct.a, rtol=0, atol=STATE)
    assert np.array_equal(found["orientation"][:, 0].to_numpy(), a0) or start == "inlet"
    assert float(found["orientation_interaction"]) == pytest.approx(C_I, rel=SAME)
    assert found["orientation_closure"].item() == "ORE"
    assert found["orientation_convention"].item() == convention
    if start == "inlet":  # the first line's flow does not change: nor does its tensor
        np.testing.assert_allclose(found["orientation"][0], np.broadcast_to(first[0], (9, 3, 3)))


GIVEN: dict[str, dict[str, float]] = {
    "folgar-tucker": {},
    "rsc": {"kappa": 0.1},
    "ard-rsc": {"b1": 1.924e-4, "b2": 5.839e-3, "b3": 0.04, "b4": 1.168e-5, "kappa": 1 / 30},
    "iard": {"anisotropy": 0.9},
    "pard": {"anisotropy": 0.8},
    "mrd": {"third": 0.2},
    "nematic": {"potential": 0.03},
    "jeffery": {},
}
"""A study of every model: what it says of it."""


def _asked(name: str) -> tuple[Interaction, dict[str, Any]]:
    """Return the table of a study with a model, and what its stage is given."""
    table = Interaction.model_validate({"model": name, **GIVEN[name]})
    return table, {key: getattr(table, key) for key in Interaction.model_fields}


@pytest.mark.parametrize("convention", ["standard", "paper"])
@pytest.mark.parametrize("name", MODELS)
def test_every_model_of_a_study_is_that_of_direct_calls(name: str, convention: str) -> None:
    lines = tiny()
    table, given = _asked(name)
    given["convention"] = convention
    found = orientation_stage(parameters(**given), {"streamlines": lines}, quiet)
    kind = MODELS[name]
    shared = {"interaction": C_I, "convention": convention}
    known = {one.name for one in fields(kind)}
    model = kind(XI, **{key: value for key, value in shared.items() if key in known}, **GIVEN[name])
    path = (lines["time"].to_numpy(), lines["gradient"].to_numpy())
    direct = follow_orientation(model, CLOSURES["ORE"], path, isotropic())
    assert np.array_equal(found["orientation"].to_numpy(), direct.a)
    usual = FolgarTucker(XI, C_I * CONVENTIONS[convention])
    other = follow_orientation(usual, CLOSURES["ORE"], path, isotropic())
    is_other = np.abs(direct.a - other.a).max() > 1e-3
    assert is_other == (name != "folgar-tucker")  # a stage that took Folgar-Tucker would be seen
    written, interaction, own = stored_model(found)
    assert (written, own) == (name, table.own)
    assert interaction == (C_I if "interaction" in known else None)
    assert ("orientation_convention" in found) == ("convention" in known)
    assert ("closure_error" in found) == (name == "folgar-tucker")
    told = [one.name for one in orientation_estimates(Parameters({}), found)]
    judged = ["closure_exact_error"] if name == "folgar-tucker" else []
    assert told == ["orientation_error", *judged]


def test_results_that_name_no_model_are_folgar_and_tuckers() -> None:
    found = orientation_stage(parameters(), {"streamlines": tiny()}, quiet)
    assert stored_model(found.drop_vars("orientation_model")) == stored_model(found)


def test_a_study_has_every_model_with_its_own_parameters() -> None:
    assert set(OWN) == set(MODELS) == set(get_args(ModelName)) == set(WRITTEN)
    for name, kind in MODELS.items():
        own = {
            one.name: None if one.default is MISSING else one.default
            for one in fields(kind)
            if one.name not in {"shape_factor", "interaction", "convention"}
        }
        assert OWN[name] == own
        assert (name in WITHOUT_COEFFICIENT) == ("interaction" not in kind.__dataclass_fields__)


@pytest.mark.parametrize(
    ("table", "line"),
    [
        (
            {"kappa": 0.1},
            'interaction.kappa = 0.1: is no parameter of interaction.model = "folgar-tucker", '
            'which takes none: leave it away, or say interaction.model = "rsc" or "ard-rsc"',
        ),
        (
            {"model": "rsc"},
            'interaction.kappa: missing: interaction.model = "rsc" cannot do without; say it, such '
            "as interaction.kappa = 0.1",
        ),
        ({"model": "rsc", "kappa": 0}, "interaction.kappa = 0: must be above 0"),
        (
            {"model": "pard", "anisotropy": 0.3},
            'interaction.model = "pard": anisotropy = 0.3 must be in [0.5, 1]',
        ),
        (
            {"model": "ard-rsc", "b1": 1e-3, "coefficient": 0.01},
            'interaction.coefficient = 0.01: interaction.model = "ard-rsc" has no such '
            "coefficient: it has b1, b2, b3, b4, b5, kappa in its place: leave it away",
        ),
        (
            {"model": "ard-rsc", "b1": 1e-3, "b4": 0.01},
            'interaction.model = "ard-rsc": along a direction of this flow the diffusion is -0.004',
        ),
        (
            {"model": "jeffery", "start": "inlet"},
            'interaction.start = "inlet": fibers that do not interact',
        ),
        ({"model": "isrc"}, 'interaction.model = "isrc": must be "folgar-tucker" or "rsc" or'),
        ({"model": ["rsc"]}, 'interaction.model = ["rsc"]: must be'),
    ],
)
def test_what_does_not_belong_to_a_model_is_one_line(table: dict[str, Any], line: str) -> None:
    with pytest.raises(ConfigError) as refused:
        resolve({"interaction": table})
    assert str(refused.value).startswith(line)
    assert "\n" not in str(refused.value)


def test_another_model_begins_anew() -> None:
    """What was said of one is not true of another; a sweep over models does the same."""
    base = {"interaction": {"model": "rsc", "kappa": 0.1, "coefficient": 0.02}}
    anew = merged(base, {"interaction": {"model": "mrd"}})
    assert anew["interaction"] == {"model": "mrd", "coefficient": 0.02}
    assert merged(base, {"interaction": {"model": "jeffery"}})["interaction"] == {
        "model": "jeffery"
    }
    kept = merged(base, {"interaction": {"closure": "ORF"}})
    assert kept["interaction"] == {**base["interaction"], "closure": "ORF"}
    axis = Axis(("interaction.model",), (("rsc",), ("folgar-tucker",), ("mrd",)))
    own = [case.config.interaction.own for case in Sweep(base, (axis,)).cases()]
    assert own == [{"kappa": 0.1}, {}, {"first": 1.0, "second": 0.8, "third": 0.15}]


def test_the_size_of_the_cell_is_folgar_and_tuckers_by_any_model() -> None:
    _, given = _asked("ard-rsc")
    assert content().identical(content(**given))


def test_the_closure_is_judged_along_the_papers_streamline() -> None:
    lines = tiny()
    found = orientation_stage(parameters(), {"streamlines": lines}, quiet)
    assert int(found["closure_streamline"]) == 3  # 0.4 is nearest to 9.5/22
    rate = 2.0  # of the simple shear, sqrt(2 D:D)
    shear = np.broadcast_to(rate * FLOWS["simple-shear"], (9, 3, 3))
    time = lines["time"][0].to_numpy()
    exact = follow_distribution(time, shear, XI, C_I * rate).distribution.second()
    np.testing.assert_allclose(found["closure_exact"].to_numpy(), exact, rtol=0, atol=SAME)
    error = np.abs(found["orientation"][0].to_numpy() - exact).max(axis=(1, 2))
    np.testing.assert_allclose(found["closure_error"].to_numpy(), error, rtol=0, atol=SAME)
    assert 1e-3 < error.max() < 0.05  # a closure is neither exact nor useless


def test_a_coefficient_stands_in_the_place_of_the_law() -> None:
    assert float(content(coefficient=0.02)["interaction_coefficient"]) == 0.02
    assert float(content(law="phan-thien")["interaction_coefficient"]) == pytest.approx(
        0.03 * -np.expm1(-0.224 * 0.504), rel=SAME
    )


def test_the_stored_curve_is_the_curve() -> None:
    stored = stored_curve(stalled())
    size, factor = np.array(CELLS).T
    curve = StallCurve(6.0, size, factor, 1e-3)
    at = np.linspace(2.2, 5.0, 7)
    assert np.array_equal(stored.stall_angle(at), curve.stall_angle(at))
    assert stored.largest_stalling_domain == curve.largest_stalling_domain
    assert (stored.fiber_aspect_ratio, stored.error) == (6.0, 1e-3)


def test_the_papers_content_gives_the_papers_cell_in_its_convention() -> None:
    paper, standard = (content(convention=name) for name in ("paper", "standard"))
    for found in (paper, standard):
        assert float(found["interaction_coefficient"]) == pytest.approx(C_I, rel=SAME)
        assert found["content_regime"].item() == "semi-dilute"
    size = float(paper["content_domain_size"])
    assert size == pytest.approx(PAPER_DOMAIN, abs=PAPER_WITHIN)
    assert float(paper["preferred_angle"]) == pytest.approx(0.1261, abs=1e-4)
    assert float(standard["preferred_angle"]) == pytest.approx(0.0967, abs=1e-4)
    assert float(standard["content_domain_size"]) > size + 0.3  # less interaction, a larger cell
    curve = stored_curve(stalled())
    assert float(curve.stall_angle(size)) == pytest.approx(float(paper["preferred_angle"]))


def test_the_distribution_needs_no_closure() -> None:
    model = folgar_tucker(6.0, 0.0128, "standard")
    a = steady_distribution(FLOWS["simple-shear"], XI, 0.0128).second()
    angle = 0.5 * np.arctan2(2 * a[0, 1], a[0, 0] - a[1, 1])
    assert preferred_angle(model, DISTRIBUTION) == pytest.approx(angle, rel=1e-10)


def test_a_cell_as_large_as_the_content_says() -> None:
    given = {
        "fiber.half_length": 42e-6,
        "fiber.aspect_ratio": 6.0,
        "fiber.thickness_ratio": None,
        "fiber.model": "confined-ellipse",
        "fiber.domain_size": "from-content",
        "fiber.pressure_reference": "mean",
        "numerics.cell_mesh": "graded",
        "numerics.cell_order": 3,
    }
    found = content(convention="paper")
    cell = cell_stage(Parameters(given), {"content": found}, quiet)
    assert float(cell["domain_size"]) == float(found["content_domain_size"])
    # B of an independent cell: it stalls where the suspension lies, to the curve of few cells
    assert float(cell["stall_angle"]) == pytest.approx(float(found["preferred_angle"]), abs=2e-3)


def test_a_circle_stalls_nowhere() -> None:
    with pytest.raises(ConfigError, match=r"fiber.aspect_ratio = 1: must be above 1; a circle"):
        stall_stage(Parameters({"fiber.aspect_ratio": 1.0}), {}, quiet)


def test_content_that_no_cell_stalls() -> None:
    with pytest.raises(ConfigError, match=r"no cell stalls a fiber of r_e = 6 there.*up to 0\.26"):
        content(coefficient=0.2)


def test_curves_stand_beside_the_paper_s() -> None:
    found = interacting()
    interaction = found["interaction"].to_numpy()
    ore = found["interaction_angle"].sel(closure="ORE")
    model = FolgarTucker(XI, float(np.sqrt(2.0) * interaction[4]))
    direct = steady_state(model, FLOWS["simple-shear"], CLOSURES["ORE"]).angle
    assert float(ore.sel(convention="paper")[4]) == pytest.approx(direct, rel=STATE)
    apart = np.abs(ore.sel(convention="paper") - paper_preferred_angle(interaction)).max()
    assert float(found["interaction_angle_difference"].sel(convention="paper")) == apart
    sizes = found["interaction_domain_size"].sel(convention="standard").to_numpy()
    apart = np.nanmax(np.abs(sizes - paper_domain_size(interaction)))
    assert float(found["interaction_domain_size_difference"][0]) == apart
    # from across the flow, ever slower, to the stall angle
    angle, spin = (found[f"stalling_{name}"].to_numpy() for name in ("angle", "spin"))
    assert np.all(np.abs(angle[:, 0] - 0.5 * np.pi) < SAME)
    assert np.all(np.diff(angle, axis=1) < 0.0)
    rest = stored_curve(stalled()).stall_angle(found["stalling_domain_size"].to_numpy())
    assert angle[0, -1] == pytest.approx(rest[0], abs=1e-3)
    assert np.all(spin[0, -1] > -1e-3)


def test_isotropy_at_the_inlet_of_every_line() -> None:
    found = oriented(4, points=30)
    np.testing.assert_array_equal(
        found["orientation"][:, 0], np.broadcast_to(isotropic(), (4, 3, 3))
    )
