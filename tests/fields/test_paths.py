"""Paths through fields whose paths are known: seeds of equal flux, times, ends, refusals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from exact_flows import EXTENSION, PIPE, SLIT, TUBE, ExactFlow, box, exact_field, rectangle

from fibermelt.errors import ConfigError
from fibermelt.fields import paths
from fibermelt.fields.field import Field
from fibermelt.fields.paths import (
    TRACING_TOLERANCE,
    FieldPath,
    Section,
    Seeds,
    flux_seeds,
    inflow_section,
    line_section,
    line_seeds,
    patch_section,
    plane_section,
    point_seeds,
    trace_field,
)
from fibermelt.fields.simplices import used_only
from fibermelt.melt import PowerLaw

Array = np.ndarray

ROUNDING = 1e-12

FOLLOWED = 20 * TRACING_TOLERANCE
"""Of lines that take fewer than 200 steps of a field with a diagonal of order one, each of which
may miss by the tolerance; the errors hardly ever add up."""


def planar(velocity: Callable[[Array, Array], tuple[Array, Array]], L: list[list[float]]) -> Field:
    """Return a flow linear in x and y on [0, 2] x [0, 1]."""
    gradient = np.zeros((3, 3))
    gradient[:2, :2] = L

    def u(x: Array) -> Array:
        return np.column_stack([*velocity(x[:, 0], x[:, 1]), 0 * x[:, 0]])

    flow = ExactFlow(
        "any",
        "planar",
        rectangle,
        u,
        lambda x: np.tile(gradient, (len(x), 1, 1)),
        lambda x: x[:, 0],
    )
    return exact_field(flow, 8)


def only(field: Field, point: list[float], most_time: float | None = None) -> FieldPath:
    (path,) = trace_field(field, point_seeds(field, [point]), 200, most_time=most_time)
    return path


def without(field: Field, is_gone: Callable[[Array], Array]) -> Field:
    """Return the field without the cells whose centres are named, as where a file has NaN."""
    keep = ~is_gone(field.points[field.cells].mean(axis=1))
    cells, kept = used_only(field.cells[keep], len(field.points))
    nodal = ("points", "velocity", "gradient", "gradient_error", "divergence")
    flags = ("near_wall", "near_edge", "cut")
    return replace(
        field,
        cells=cells,
        pressure=field.pressure[kept],
        **{name: getattr(field, name)[kept] for name in (*nodal, *flags)},
    )


@pytest.mark.parametrize("way", ["line", "sticking out", "inflow"])
def test_equal_flux_in_a_tube(way: str) -> None:
    """``r = R sqrt(1 - sqrt(1 - f))``, as the flux within r is ``1 - (1 - r^2)^2`` of the whole."""
    errors = []
    for n in (6, 12):
        field = exact_field(TUBE, n)
        section = {
            "line": lambda f: line_section(f, [1.0, 0.0], [1.0, 1.0]),
            "sticking out": lambda f: line_section(f, [1.03, -0.5], [1.03, 1.5]),
            "inflow": inflow_section,
        }[way](field)
        assert section.flux == pytest.approx(
            np.pi, rel=ROUNDING
        )  # Simpson's rule: 2 pi r u is cubic
        seeds = flux_seeds(field, section, 11)
        assert seeds.flux == section.flux
        f = (np.arange(11) + 0.5) / 11
        np.testing.assert_allclose(seeds.flux_fraction, f, atol=ROUNDING)
        errors.append(np.max(np.abs(seeds.points[:, 1] - np.sqrt(1 - np.sqrt(1 - f)))))
        np.testing.assert_allclose(seeds.points[:, 2], 0.0)
    # the density's cubic is a quadratic in each segment: its integral is of order four, in pieces
    # of other lengths on the other mesh
    assert np.log2(errors[0] / errors[1]) > 3.5
    assert errors[1] < 1e-5


def test_equal_flux_in_a_slit_is_exact_and_in_order_from_the_first_end() -> None:
    field = exact_field(SLIT, 6)
    for start, stop, sign in (([0.7, 0.0], [0.7, 1.0], 1), ([0.7, 1.0], [0.7, 0.0], -1)):
        seeds = flux_seeds(field, line_section(field, start, stop), 9)
        z = seeds.points[::sign, 1]
        np.testing.assert_allclose(3 * z**2 - 2 * z**3, (np.arange(9) + 0.5) / 9, atol=ROUNDING)
        assert seeds.flux == pytest.approx(1.0, rel=ROUNDING)


def test_a_part_of_a_line_has_its_own_flux() -> None:
    field = exact_field(SLIT, 6)
    section = line_section(field, [0.4, 0.21], [0.9, 0.57])  # in cells, and not straight across
    flux = np.diff([3 * z**2 - 2 * z**3 for z in (0.21, 0.57)])[0]
    assert section.flux == pytest.approx(flux, rel=ROUNDING)


@pytest.mark.parametrize(
    ("point", "normal"),
    [
        ([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]),  # in the inlet: there are cells on one side only
        ([1.0, 0.0, 0.0], [-3.0, 0.0, 0.0]),
        ([0.47, 0.0, 0.0], [1.0, 0.3, -0.2]),
    ],
)
def test_the_flux_through_a_pipe_is_the_same_in_every_plane(
    point: list[float], normal: list[float]
) -> None:
    misses = []
    for n in (4, 8):
        section = plane_section(exact_field(PIPE, n), point, normal)
        misses.append(np.pi - section.flux)
    # what the polygon leaves of the disk carries nothing: two orders more than its area
    assert np.log2(misses[0] / misses[1]) == pytest.approx(4.0, abs=0.2)


def test_quarters_of_a_pipe_begin_at_their_centres_of_flux() -> None:
    """Of a quarter of the disk with ``2 (1 - r^2)``: 16/(15 pi) from both its sides."""
    field = exact_field(PIPE, 8)
    section = plane_section(field, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0])
    seeds = flux_seeds(field, section, 4)
    at = 16 / (15 * np.pi)
    quarters = [[0, -at, -at], [0, -at, at], [0, at, -at], [0, at, at]]
    # 64 samples of each quarter's flux, and the polygon
    np.testing.assert_allclose(seeds.points, quarters, atol=2e-3)
    inflow = flux_seeds(field, inflow_section(field), 4)
    np.testing.assert_allclose(inflow.points, quarters, atol=2e-3)


def test_parts_in_space_are_equal_for_any_count() -> None:
    """Of a plug in the unit square: equal areas, so that a third's centre is at 1/6."""
    flow = ExactFlow(
        "plug",
        "spatial",
        box,
        lambda x: np.tile([1.0, 0.0, 0.0], (len(x), 1)),
        lambda x: np.zeros((len(x), 3, 3)),
        lambda x: x[:, 0],
    )
    field = exact_field(flow, 4)
    seeds = flux_seeds(field, plane_section(field, [0.5, 0, 0], [1, 0, 0]), 3)
    # the slab of a third, and the rest in halves across it
    exact = [[0.5, 1 / 6, 0.5], [0.5, 2 / 3, 0.25], [0.5, 2 / 3, 0.75]]
    # 64 samples of each, an eighth of its extent apart: a row of them may be on the other side
    np.testing.assert_allclose(seeds.points, exact, atol=4e-3)
    assert seeds.flux == pytest.approx(1.0, rel=ROUNDING)
    patch = plane_section(field, [0.5, 0.5, 0.5], [1, 0, 0], radius=0.3)
    assert 0.15 < patch.flux < 0.35  # pieces of the mesh about a disk of 0.28
    half = patch_section(field, [0.0, 0.0, 0.5], [0.0, 1.0, 1.0])  # cells end at its edge
    assert half.flux == pytest.approx(0.5, rel=ROUNDING)
    assert np.all(half.points[..., 2] >= 0.5)


def test_what_flows_back_has_no_seeds() -> None:
    section = Section(np.array([[[0, 0, 0], [0, 1, 0]], [[0, 1, 0], [0, 2, 0.0]]]), np.ones((2, 3)))
    mixed = replace(section, density=section.density * [[1.0], [-0.5]])
    assert mixed.flux == 0.5
    seeds = flux_seeds(exact_field(SLIT, 2), mixed, 3)
    np.testing.assert_allclose(seeds.points[:, 1], [1 / 6, 1 / 2, 5 / 6], atol=ROUNDING)
    assert seeds.flux == 1.0


def test_seeds_on_a_line_and_at_points() -> None:
    field = exact_field(SLIT, 2)
    line = line_seeds(field, [0.0, 0.2], [0.0, 0.8], 4)
    np.testing.assert_allclose(line.points[:, 1], [0.2, 0.4, 0.6, 0.8])
    assert line_seeds(field, [0.0, 0.2], [0.0, 0.8], 1).points.tolist() == [[0.0, 0.5, 0.0]]
    assert point_seeds(field, [[0.1, 0.3]]).points.tolist() == [[0.1, 0.3, 0.0]]
    assert line.flux is None
    assert line.flux_fraction is None


@pytest.mark.parametrize("flow", [SLIT, TUBE, PIPE])
def test_transit_times_of_straight_paths(flow: ExactFlow) -> None:
    field = exact_field(flow, 6)
    seeds = flux_seeds(field, inflow_section(field), 5)
    length = 1.0 if flow is PIPE else 2.0
    speed = np.linalg.norm(flow.velocity(seeds.points), axis=1)
    for path, exact in zip(trace_field(field, seeds, 300), speed, strict=True):
        h = path.history
        assert path.end == "outlet"
        assert h.time[-1] == pytest.approx(length / exact, rel=FOLLOWED)
        np.testing.assert_allclose(h.position[:, 1:] - h.position[0, 1:], 0.0, atol=FOLLOWED)
        np.testing.assert_allclose(h.pressure, flow.pressure(h.position), atol=ROUNDING)
        # exact nodes, linear between: of order two
        np.testing.assert_allclose(h.gradient, flow.gradient(h.position), atol=0.1)
        assert h.planar == (flow is not PIPE)
        assert path.consistency.transport < FOLLOWED
    assert [path.index for path in trace_field(field, seeds, 50)] == [1, 2, 3, 4, 5]


def test_axisymmetric_extension() -> None:
    """``x = x_0 exp(2 t)``, ``r = r_0 exp(-t)`` stay on ``x r^2``, and stretch across as well."""
    field = exact_field(EXTENSION, 8)
    for path in trace_field(field, line_seeds(field, [0.05, 0.9], [0.2, 0.9], 3), 300):
        h = path.history
        assert path.end == "outlet"
        assert h.position[-1, 0] == pytest.approx(2.0, abs=FOLLOWED)
        stretch = np.exp(2 * h.time)
        np.testing.assert_allclose(h.position[:, 0], h.position[0, 0] * stretch, atol=FOLLOWED)
        np.testing.assert_allclose(h.position[:, 1], 0.9 * np.exp(-h.time), atol=FOLLOWED)
        np.testing.assert_allclose(h.gradient - np.diag([2.0, -1, -1]), 0.0, atol=ROUNDING)
        assert not h.planar
        assert path.consistency.steadiness < 1e-4  # of the trapezoidal rule
        assert path.divergence == 0.0


def test_a_closed_line_ends_by_its_time() -> None:
    field = planar(lambda x, y: (-3.0 * (y - 0.5), 3.0 * (x - 1.0)), [[0, -3], [3, 0]])
    turn = 2 * np.pi / 3
    path = only(field, [1.3, 0.5], most_time=2.25 * turn)
    h = path.history
    assert path.end == "time"
    assert h.time[-1] == pytest.approx(2.25 * turn, rel=1e-9)
    radius = np.hypot(h.position[:, 0] - 1.0, h.position[:, 1] - 0.5)
    np.testing.assert_allclose(radius, 0.3, atol=1e-5)  # of 2 turns
    np.testing.assert_allclose(h.position[-1], [1.0, 0.8, 0.0], atol=1e-5)


def test_the_most_time_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    field = planar(lambda x, y: (-3.0 * (y - 0.5), 3.0 * (x - 1.0)), [[0, -3], [3, 0]])
    monkeypatch.setattr(paths, "LONGEST", 2.0)
    speed = np.sqrt(np.mean(np.sum(field.velocity**2, axis=1)))
    path = only(field, [1.3, 0.5])
    assert path.end == "time"
    assert path.history.time[-1] == pytest.approx(2.0 * np.sqrt(5) / speed)


def test_a_line_ends_at_a_stagnation_point() -> None:
    """The way down to a point at rest: ``y = exp(-t)`` takes for ever, so it ends before."""
    inside = planar(lambda x, y: (x - 1.0, -(y - 0.5)), [[1, 0], [0, -1]])
    path = only(inside, [1.0, 0.9])
    assert path.end == "stagnation"
    h = path.history
    np.testing.assert_allclose(h.position[-1], [1.0, 0.5, 0.0], atol=2e-6)
    # time is held to the tolerance as well: a millionth of a diagonal at the speed of the place
    np.testing.assert_allclose(h.position[:, 1] - 0.5, 0.4 * np.exp(-h.time), atol=2e-6)
    corner = exact_field(EXTENSION, 6)  # on the axis, which is the field's edge, no wall
    assert only(corner, [0.0, 0.9]).end == "stagnation"


def test_a_line_ends_where_it_creeps_to_a_wall() -> None:
    """``u = (x - 1) y, v = -y^2/2``, at rest for y = 0."""
    mesh = rectangle(8)

    def gradient(x: Array) -> Array:
        L = np.zeros((len(x), 3, 3))
        L[:, 0, 0], L[:, 0, 1], L[:, 1, 1] = x[:, 1], x[:, 0] - 1.0, -x[:, 1]
        return L

    flow = ExactFlow(
        "impinging",
        "planar",
        lambda _: mesh,
        lambda x: np.column_stack([(x[:, 0] - 1) * x[:, 1], -0.5 * x[:, 1] ** 2, 0 * x[:, 0]]),
        gradient,
        lambda x: x[:, 0],
    )
    path = only(exact_field(flow, 8), [1.0, 0.9], most_time=1e6)
    assert path.end == "wall"
    assert path.history.position[-1, 1] < 0.01


def test_a_line_that_leaves_where_nothing_flows_out_ends_at_a_wall() -> None:
    drifting = planar(lambda x, y: (1.0 + 0 * x, 0.01 + 0 * x), [[0, 0], [0, 0]])
    assert only(drifting, [0.0, 0.995]).end == "wall"
    assert only(drifting, [0.0, 0.5]).end == "outlet"


def test_a_line_that_ends_where_the_file_has_no_numbers_tells_so() -> None:
    field = without(exact_field(SLIT, 8), lambda x: x[:, 0] > 1.2)
    marked = replace(field, cut=field.points[:, 0] > 1.0)
    path = only(marked, [0.0, 0.5])
    assert path.cut
    assert "where the file has no numbers beyond" in path.told[-1]
    whole = only(field, [0.0, 0.5])
    assert not whole.cut
    assert whole.told == ()


def test_a_line_ends_where_the_numbers_do() -> None:
    field = without(exact_field(SLIT, 8), lambda x: x[:, 0] > 1.2)
    path = only(field, [0.0, 0.5])
    assert path.history.position[-1, 0] == pytest.approx(field.points[:, 0].max(), abs=0.2)


def test_what_a_path_tells() -> None:
    field = exact_field(SLIT, 8)
    marked = replace(
        field,
        divergence=np.full(len(field.points), 0.06),
        gradient_error=1e-3 * field.points[:, 0],
        near_edge=field.points[:, 1] < 0.3,
        temperature=500.0 + field.points[:, 0],
        pressure=None,
    )
    law = PowerLaw(100.0, 0.5)
    seeds = line_seeds(marked, [0.0, 0.1], [0.0, 0.9], 2)
    low, high = trace_field(marked, seeds, 100, law)
    assert low.near_singularity
    assert not high.near_singularity
    h = high.history
    np.testing.assert_allclose(high.gradient_error, 1e-3 * h.position[:, 0], atol=ROUNDING)
    np.testing.assert_allclose(h.temperature, 500 + h.position[:, 0], rtol=ROUNDING)
    np.testing.assert_allclose(h.viscosity, law.viscosity_at(h.shear_rate), rtol=ROUNDING)
    assert np.all(h.pressure == 0.0)
    size = np.max(np.linalg.norm(h.gradient, axis=(1, 2)))
    assert high.divergence == pytest.approx(0.06 / size, rel=ROUNDING)
    own = replace(field, viscosity=np.full(len(field.points), 7.0))
    (path,) = trace_field(own, point_seeds(own, [[0.0, 0.5]]), 100, law)
    np.testing.assert_allclose(path.history.viscosity, 7.0)
    (bare,) = trace_field(field, point_seeds(field, [[0.0, 0.5]]), 100)
    assert bare.history.viscosity is None


SLIT_FIELD, PIPE_FIELD = exact_field(SLIT, 4), exact_field(PIPE, 3)
HOLED = without(SLIT_FIELD, lambda x: np.hypot(x[:, 0] - 1.0, x[:, 1] - 0.5) < 0.3)
TUBE_FIELD = exact_field(TUBE, 4)
SWIRLING = replace(TUBE_FIELD, velocity=TUBE_FIELD.velocity + np.array([0.0, 0.0, 0.1]))


@pytest.mark.parametrize(
    ("attempt", "match"),
    [
        (lambda: only(SLIT_FIELD, [2.5, 0.5]), r"1 of 1 seeds lie outside .* seed 1 at \(2.5, 0.5"),
        (lambda: only(HOLED, [1.0, 0.5]), "or where it has no numbers"),
        (lambda: only(SLIT_FIELD, [0.5, 0.0]), r"where the melt stands, the first .* off the wall"),
        (lambda: only(SLIT_FIELD, [2.0, 0.5]), "path 1 ends .* seed it upstream"),
        (lambda: only(SWIRLING, [0.1, 0.5]), r"turns about its axis at up to 0.1 m/s"),
        (lambda: trace_field(SLIT_FIELD, Seeds(np.zeros((1, 3))), 20), "points = 20: must be"),
        (lambda: point_seeds(SLIT_FIELD, [[0.1, 0.2, 0.3]]), "the field is planar, at z = 0"),
        (lambda: point_seeds(SLIT_FIELD, [[0.1]]), "points of 2 finite coordinates"),
        (lambda: point_seeds(PIPE_FIELD, [[0.1, 0.2]]), "points of 3 finite coordinates"),
        (lambda: point_seeds(SLIT_FIELD, [[0.1, np.nan]]), r"paths.points = .*finite"),
        (lambda: line_seeds(SLIT_FIELD, [0, 0], [0, 0], 3), "paths.from and paths.to are both"),
        (lambda: line_seeds(SLIT_FIELD, [0, 0], [0, 1], 0), "paths.count = 0"),
        (lambda: line_section(PIPE_FIELD, [0, 0, 0], [0, 1, 0]), "give a plane, or the inflow"),
        (lambda: plane_section(SLIT_FIELD, [0, 0], [1, 0]), "no section of a planar flow"),
        (lambda: plane_section(PIPE_FIELD, [5, 0, 0], [1, 0, 0]), "no cells in the plane through"),
        (
            lambda: plane_section(PIPE_FIELD, [0, 0, 0], [0, 0, 0]),
            "the plane's normal has no length",
        ),
        (lambda: patch_section(PIPE_FIELD, [0, 0, 0], [0, 0, 1]), "one coordinate in common"),
        (lambda: patch_section(PIPE_FIELD, [0, 0, 0], [1, 1, 1]), "one coordinate in common"),
        (lambda: line_section(SLIT_FIELD, [3, 0], [3, 1]), r"no cells in the line from \(3, 0\)"),
        (lambda: line_section(SLIT_FIELD, [0, 0.5], [1, 0.5]), "nothing flows through the line"),
    ],
)
def test_refusals(attempt: Callable[[], object], match: str) -> None:
    with pytest.raises(ConfigError, match=match):
        attempt()
