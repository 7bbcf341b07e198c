"""Paths through a field: where they begin, how they are followed, and why they end.

Seeds of equal flux lie in a section of the field: a line across a flow in the plane or along the
radius, a plane or the inflow in space. A section in the plane has an order, and its seeds stand
where ``(k - 1/2)/count`` of the flux has passed. One in space has none: it is halved by flux
across its longer extent, the halves again, until every part has one path (in unequal numbers where
the count asks for it), which begins at the part's centre of flux. That does for a section of any
outline, where rings and sectors need a round one. In either case each path stands for the same
flux. What flows the other way through the section has no seeds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import Unchanging, real_array
from fibermelt.errors import ConfigError, ConvergenceError, refuse_no_count, refuse_other
from fibermelt.fields.field import Field, Place
from fibermelt.flow.tracing import Path, Rules, follow_lines
from fibermelt.history import Consistency, FlowHistory
from fibermelt.melt import ViscosityLaw

__all__ = [
    "FieldPath",
    "PathEnd",
    "Section",
    "Seeds",
    "flux_seeds",
    "inflow_section",
    "line_section",
    "line_seeds",
    "patch_section",
    "plane_section",
    "point_seeds",
    "trace_field",
]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

PathEnd = Literal["outlet", "wall", "stagnation", "time"]

TRACING_TOLERANCE = 1e-7
"""Error allowed per step, in diagonals of the field: velocities between nodes, quadratic in cells
of a hundredth of it, are good to 1e-6 at best."""

LARGEST_STEP = 0.02
"""Longest step in diagonals of the field: several cells, whose faces the error control sees."""

STILL = 1e-6
"""Parts of the field's highest speed below which the melt stands: a line has crept there for about
as long as it took all the way before."""

OPEN = 0.02
"""Part of a cell's highest speed that must leave through its facet, on the mean, for the boundary
to be open there: one degree. A wall lets through what the discretisation leaves; a moving round one
drawn with facets as much out as in."""

REACH = 1e-4
"""Longest steps within which a line that has left must meet the boundary; it stops 1e-7 before."""

LONGEST = 100.0
"""Default of the most time, in diagonals over the field's mean (root of mean square) speed: lines
at a hundredth of it arrive, closed ones end."""

SHORTEST = 1e-3
"""Way in diagonals of the field below which a line is no path: it begins where it ends."""

DOUBTFUL = 0.5
"""Part of the gradient that its error may be on a path that is trusted."""

FAINT = 0.1
"""Part of a path's largest gradient below which errors are held against that: elsewhere nothing
happens to a fiber."""

FLAT = 1e-9
"""Parts of the field's extent within which nodes lie in a plane: rounding."""

OPTIONAL = ("pressure", "viscosity", "temperature")
"""What a field may lack."""

TOGETHER = 32
"""Lines sampled at a time: 40 MB."""

SAMPLES = 64
"""Pieces of a section's flux for each path: its centre is then known to a few per cent of its
extent, its flux exactly."""


@dataclass(frozen=True, eq=False)
class Section(Unchanging):
    """A section of a field by a line or a plane, in segments or triangles.

    Parameters
    ----------
    points : (f, d, 3) array
        Corners [m]; segments (d = 2) in their order along the line.
    density : (f, d (d + 1)/2) array
        Velocity across [m/s] at the corners, then at the middles of the edges, the flux's way
        positive; times ``2 pi r`` in an axisymmetric flow. Quadratic between.
    """

    points: Array
    density: Array

    @property
    def size(self) -> Array:
        """Return the length [m] or area [m2] of each piece, (f,)."""
        sides = self.points[:, 1:] - self.points[:, :1]
        if self.points.shape[1] == 2:
            return np.asarray(np.linalg.norm(sides[:, 0], axis=-1))
        return np.asarray(0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=-1))

    @property
    def flux(self) -> float:
        """Return what passes in all [m3/s], [m2/s] of a planar flow, by Simpson's rule.

        The rule of the edges' middles in space; both are exact for quadratics.
        """
        if self.points.shape[1] == 2:
            mean = self.density @ np.array([1.0, 1.0, 4.0]) / 6.0
        else:
            mean = self.density[:, 3:].mean(axis=1)
        return float(self.size @ mean)


@dataclass(frozen=True, eq=False)
class Seeds(Unchanging):
    """Where paths begin.

    Parameters
    ----------
    points : (k, 3) array
        [m].
    flux_fraction : (k,) array, optional
        Part of the section's flux [-] on the first side of each: its middle in the order of the
        seeds. None where seeds stand for no flux.
    flux : float, optional
        What all of them stand for [m3/s] ([m2/s] of a planar flow), each for as much.
    """

    points: Array
    flux_fraction: Array | None = None
    flux: float | None = None


@dataclass(frozen=True, eq=False)
class FieldPath(Unchanging):
    """A path through a field, from its seed to its end, in SI units.

    Parameters
    ----------
    index : int
        1 for the first seed.
    flux_fraction : float or None
        Its seed's.
    history : FlowHistory
        What a material point meets on it.
    gradient_error : (n,) array
        Estimated error of the velocity gradient along it [1/s], Frobenius.
    divergence : float
        The largest trace that was removed from the gradient along it, in parts of the largest
        gradient (Frobenius) [-].
    end : {"outlet", "wall", "stagnation", "time"}
        Why it ends: the flow leaves the field, it comes to rest or runs into the boundary where
        nothing leaves, it comes to rest inside, its time is over.
    near_singularity : bool
        Whether it passes close by a sharp edge, or where the gradient's error is a part of the
        gradient that says nothing of it any more (`DOUBTFUL`).
    cut : bool
        Whether it ends where the file has no numbers beyond.
    """

    index: int
    flux_fraction: float | None
    history: FlowHistory
    gradient_error: Array
    divergence: float
    end: PathEnd
    near_singularity: bool
    cut: bool = False

    @property
    def told(self) -> tuple[str, ...]:
        """Return what does not fit, in words; empty if all does."""
        x, y, z = self.history.position[-1]
        cut = f"ends at ({x:.4g}, {y:.4g}, {z:.4g}) m, where the file has no numbers beyond"
        return (*self.consistency.told, *([cut] if self.cut else []))

    @property
    def consistency(self) -> Consistency:
        """Return how well position, velocity and gradient along it agree."""
        return self.history.consistency()


def line_seeds(field: Field, start: ArrayLike, stop: ArrayLike, count: int) -> Seeds:
    """Return seeds at equal distances on a line, both ends among them; one alone in its middle.

    Parameters
    ----------
    field : Field
        The flow.
    start, stop : (3,) array_like
        The line's ends [m], (2,) in a planar or axisymmetric field.
    count : int
        Number of seeds.

    Raises
    ------
    ConfigError
        If an end is no point, both are the same, or there is no count.
    """
    refuse_no_count("paths.count", count)
    a, b = _line(field, start, stop)
    part = np.linspace(0.0, 1.0, count) if count > 1 else np.array([0.5])
    return Seeds(a + part[:, None] * (b - a))


def point_seeds(field: Field, points: ArrayLike) -> Seeds:
    """Return seeds at given points.

    Parameters
    ----------
    field : Field
        The flow.
    points : (k, 3) array_like
        [m]; (k, 2) in a planar or axisymmetric field.

    Raises
    ------
    ConfigError
        If they are no points.
    """
    return Seeds(_points(field, "paths.points", points))


def flux_seeds(field: Field, section: Section, count: int) -> Seeds:
    """Return seeds in a section, each of which stands for the same flux.

    Parameters
    ----------
    field : Field
        The flow.
    section : Section
        Of `line_section`, `plane_section` or `inflow_section`.
    count : int
        Number of seeds.

    Raises
    ------
    ConfigError
        If there is no count.

    Notes
    -----
    See the module's docstring. Where the melt flows back through the section the density counts as
    zero.
    """
    refuse_no_count("paths.count", count)
    forward = Section(section.points, np.maximum(section.density, 0.0))
    fraction = (np.arange(count) + 0.5) / count
    if section.points.shape[1] == 2:
        seeds = _along(forward, fraction)
    else:
        seeds = _halved(field, *_samples(forward, SAMPLES * count), count)
    return Seeds(seeds, fraction, forward.flux)


def line_section(field: Field, start: ArrayLike, stop: ArrayLike) -> Section:
    """Return the section of a planar or axisymmetric flow by a line.

    Parameters
    ----------
    field : Field
        The flow.
    start, stop : (2,) array_like
        The line's ends [m]; in order from the first. A line that sticks out of the field is cut.

    Raises
    ------
    ConfigError
        If the flow is in space, or nothing flows across.
    """
    if field.geometry == "spatial":
        msg = "paths.seeds: a line is no section of a flow in space: give a plane, or the inflow"
        raise ConfigError(msg)
    a, b = _line(field, start, stop)
    along = b - a
    normal = np.array([-along[1], along[0], 0.0]) / np.hypot(along[0], along[1])
    cell, weights = _cut(field, a, normal)
    part = np.einsum("fcp,fpi,i->fc", weights, field.points[field.cells[cell]] - a, along)
    part /= along @ along
    # cut at the line's ends, where a piece reaches beyond
    limits = np.clip(part, 0.0, 1.0)
    span = part[:, 1] - part[:, 0]
    share = (limits - part[:, :1]) / np.where(span == 0.0, 1.0, span)[:, None]
    weights = weights[:, :1] + share[..., None] * (weights[:, 1:] - weights[:, :1])
    turned = span < 0.0
    weights[turned] = weights[turned, ::-1]
    order = np.argsort(part.mean(axis=1), kind="stable")
    where = f"the line from {_place(a[:2])} to {_place(b[:2])} m"
    return _section(field, cell[order], weights[order], normal, where)


def plane_section(
    field: Field, point: ArrayLike, normal: ArrayLike, radius: float = np.inf
) -> Section:
    """Return the section of a flow in space by a plane, or by a round patch of one.

    Parameters
    ----------
    field : Field
        The flow.
    point : (3,) array_like
        A point of the plane, the patch's middle [m].
    normal : (3,) array_like
        At right angles to it [-], of any length.
    radius : float
        The patch's radius [m]: pieces with their middle inside count.

    Raises
    ------
    ConfigError
        If the flow is not in space, the normal is none, or nothing flows across.
    """
    if field.geometry != "spatial":
        msg = f"paths.seeds: a plane is no section of a {field.geometry} flow: give a line"
        raise ConfigError(msg)
    x, n = _point(field, "the plane's point", point), _point(field, "the plane's normal", normal)
    length = float(np.linalg.norm(n))
    if length == 0.0:
        msg = "the plane's normal has no length: must be a direction, e.g. [1, 0, 0]"
        raise ConfigError(msg)
    where = f"the plane through {_place(x)} m across {_place(n)}"
    where += f" within {radius:.4g} m" if np.isfinite(radius) else ""
    reach = np.array([radius, np.inf, np.inf, np.inf])
    return _plane_piece(field, x, n / length, reach, where)


def patch_section(field: Field, start: ArrayLike, stop: ArrayLike) -> Section:
    """Return the section of a flow in space by a rectangle across x, y or z.

    Parameters
    ----------
    field : Field
        The flow.
    start, stop : (3,) array_like
        Opposite corners [m], with one coordinate in common: pieces with their middle inside count.

    Raises
    ------
    ConfigError
        If the flow is not in space, the corners have no or more than one coordinate in common, or
        nothing flows across.
    """
    a, b = _line(field, start, stop)
    extent = float(np.max(field.bounds[1] - field.bounds[0]))
    common = np.abs(b - a) <= FLAT * extent
    if field.geometry != "spatial" or np.sum(common) != 1:
        msg = (
            f"paths.from = {_place(a)} m and paths.to = {_place(b)} m: opposite corners of a "
            "rectangle across x, y or z in a flow in space have one coordinate in common"
        )
        raise ConfigError(msg)
    where = f"the rectangle from {_place(a)} to {_place(b)} m"
    reach = np.where(common, np.inf, 0.5 * np.abs(b - a))
    return _plane_piece(
        field, 0.5 * (a + b), common.astype(np.float64), np.r_[np.inf, reach], where
    )


def _plane_piece(field: Field, middle: Array, normal: Array, reach: Array, where: str) -> Section:
    """Return the section by a plane, of pieces within reach of a middle.

    In a straight line, and along x, y and z.
    """
    cell, weights = _cut(field, middle, normal)
    off = np.einsum("fcp,fpi->fi", weights, field.points[field.cells[cell]]) / 3.0 - middle
    off = np.column_stack([np.linalg.norm(off, axis=1), np.abs(off)])
    near = np.all(off <= reach, axis=1)
    return _section(field, cell[near], weights[near], normal, where)


def inflow_section(field: Field) -> Section:
    """Return the part of a field's boundary through which the melt flows in.

    In a planar or axisymmetric flow its segments are in order along their longer extent.

    Raises
    ------
    ConfigError
        If nothing flows in.
    """
    edge = _Boundary(field)
    inward = np.flatnonzero(edge.leaving < -OPEN)
    k = field.cells.shape[1]
    corners = np.array([[j for j in range(k) if j != i] for i in range(k)])
    weights = np.eye(k)[corners[edge.corner[inward]]]
    normal = -edge.normal[inward]
    middle = field.points[edge.nodes[inward]].mean(axis=1)
    if k == 3 and inward.size:
        axis = int(np.argmax(np.ptp(middle, axis=0)))
        order = np.argsort(middle[:, axis], kind="stable")
        ends = field.points[edge.nodes[inward]][..., axis]
        turned = ends[:, 0] > ends[:, 1]
        weights[turned] = weights[turned, ::-1]
        inward, weights, normal = inward[order], weights[order], normal[order]
    return _section(field, edge.cell[inward], weights, normal, "the boundary, inwards")


def trace_field(
    field: Field,
    seeds: Seeds,
    points: int = 1500,
    law: ViscosityLaw | None = None,
    most_time: float | None = None,
) -> tuple[FieldPath, ...]:
    """Return the paths from the seeds to their ends, each with so many points.

    Parameters
    ----------
    field : Field
        The flow.
    seeds : Seeds
        Where they begin.
    points : int
        Points on each, spread over way and strain as on the streamlines of a deposition flow
        (`fibermelt.flow.tracing.Path.spread`).
    law : ViscosityLaw, optional
        The melt, for the viscosity along the paths where the field has none of its own.
    most_time : float, optional
        Time after which a path ends [s]; `LONGEST` if not given.

    Raises
    ------
    ConfigError
        If a seed lies outside the field (where its file has no numbers is outside, too) or in melt
        that stands, or leaves at once; if there are fewer than 50 points; if the flow turns about
        its axis of symmetry.
    ConvergenceError
        If a point between two steps lies outside the field.

    Notes
    -----
    Paths of an axisymmetric flow stay in their meridian plane: the frame of axis, radius and
    azimuth does not turn, and the gradient there has ``u_r/r`` across. A field without pressure
    has zero: pressures on a fiber are then those over the melt's own.
    """
    refuse_other("field", field, Field)
    refuse_other("seeds", seeds, Seeds)
    refuse_no_count("points", points, 50)
    speed = np.linalg.norm(field.velocity, axis=1)
    fastest = float(speed.max())
    _refuse_swirl(field, fastest)
    place = field.locate(seeds.points)
    _refuse_seeds(field, seeds, place, STILL * fastest)
    diagonal = float(np.linalg.norm(np.subtract(*field.bounds)))
    if most_time is None:
        most_time = LONGEST * diagonal / float(np.sqrt(np.mean(speed**2)))
    rules = Rules(
        tolerance=TRACING_TOLERANCE * diagonal,
        largest_step=LARGEST_STEP * diagonal,
        least_speed=STILL * fastest,
        most_time=most_time,
        between=True,
    )
    edge = _Boundary(field)
    lines = follow_lines(field, seeds.points, rules)
    for k, line in enumerate(lines):
        if line.length < SHORTEST * diagonal:
            msg = (
                f"paths: path {k + 1} ends {line.length:.3g} m from its seed at "
                f"{_place(seeds.points[k])} m: seed it upstream, or turn the section"
            )
            raise ConfigError(msg)
    sampler = _Sampler(field, points)
    met = [
        one
        for first in range(0, len(lines), TOGETHER)
        for one in sampler.along(lines[first : first + TOGETHER])
    ]
    fractions = seeds.flux_fraction
    return tuple(
        FieldPath(
            index=k + 1,
            flux_fraction=None if fractions is None else float(fractions[k]),
            history=_history(one, law),
            gradient_error=one["gradient_error"],
            divergence=_part(one["divergence"], one["gradient"]),
            end=edge.end(lines[k], REACH * rules.largest_step),
            cut=edge.is_cut(lines[k], REACH * rules.largest_step),
            near_singularity=_in_doubt(one),
        )
        for k, one in enumerate(met)
    )


class _Sampler:
    """What is met on lines, at so many points of each: the field's nodal values side by side."""

    def __init__(self, field: Field, count: int) -> None:
        self.field = field
        self.count = count
        self.rate = np.sqrt(0.5) * np.linalg.norm(
            field.gradient + field.gradient.swapaxes(1, 2), axis=(1, 2)
        )
        wanted = ("gradient_error", "divergence", "near_edge", *OPTIONAL)
        self.names = [name for name in wanted if getattr(field, name) is not None]
        columns = [getattr(field, name) for name in self.names]
        self.table = np.column_stack([field.gradient.reshape(-1, 9), *columns])

    def along(self, lines: list[Path]) -> list[dict[str, Array]]:
        """Return time, position, velocity and what the field has, by name, on each line."""
        field, count = self.field, self.count
        position = np.concatenate([line.position for line in lines])
        place = field.locate(position, self._guess([line.cell for line in lines]))
        rate = np.split(
            field.evaluate(self.rate, place), np.cumsum([len(line.cell) for line in lines])[:-1]
        )
        at = [line.spread(one, count) for line, one in zip(lines, rate, strict=True)]
        states = [line.at(one) for line, one in zip(lines, at, strict=True)]
        position = np.concatenate([x for x, _ in states])
        cells = [
            line.cell[np.searchsorted(line.arclength, one, side="right") - 1]
            for line, one in zip(lines, at, strict=True)
        ]
        place = field.locate(position, self._guess(cells))
        if not place.found.all():
            lost = position[~place.found][0]
            msg = f"paths: a point between two steps, {_place(lost)} m, lies outside the field"
            raise ConvergenceError(msg)
        table = field.evaluate(self.table, place)
        velocity = field.velocity_at(place)
        met = []
        for k, (x, time) in enumerate(states):
            rows = slice(k * count, (k + 1) * count)
            one = {"time": time, "position": x, "velocity": velocity[rows]}
            one["gradient"] = table[rows, :9].reshape(-1, 3, 3)
            one |= dict(zip(self.names, table[rows, 9:].T, strict=True))
            met.append(one)
        return met

    def _guess(self, cells: list[Index]) -> Place:
        cell = np.concatenate(cells)
        return Place(cell, np.zeros((len(cell), self.field.dimension)))


def _history(met: dict[str, Array], law: ViscosityLaw | None) -> FlowHistory:
    """Return the history of what is met on a line."""
    values = {name: met[name] for name in ("time", "position", "velocity", "gradient")}
    values |= {name: met[name] for name in OPTIONAL if name in met}
    values.setdefault("pressure", np.zeros(len(met["time"])))
    history = FlowHistory(**values)
    if law is None or history.viscosity is not None:
        return history
    return replace(history, viscosity=np.asarray(law.viscosity_at(history.shear_rate)))


def _in_doubt(met: dict[str, Array]) -> bool:
    """Return whether the gradient along a path is singular or not known somewhere."""
    size = np.linalg.norm(met["gradient"], axis=(1, 2))
    lost = met["gradient_error"] > DOUBTFUL * np.maximum(size, FAINT * size.max())
    return bool(np.any(met["near_edge"] > 0.5) or np.any(lost))


def _part(trace: Array, gradient: Array) -> float:
    """Return the largest trace in parts of the largest gradient; none of melt without either."""
    size = float(np.max(np.linalg.norm(gradient, axis=(1, 2))))
    return float(np.max(np.abs(trace))) / size if size > 0.0 else 0.0


class _Boundary:
    """The facets that belong to one cell, and what passes through them.

    ``cell``, ``corner`` (the one opposite), ``nodes`` and outward ``normal`` of each; ``leaving``,
    the mean velocity outwards of its nodes in parts of the cell's highest speed; ``is_still``, of
    all nodes of the field, whether they belong to a facet that rests.
    """

    def __init__(self, field: Field) -> None:
        self.field = field
        self.cell, self.corner = np.nonzero(field.facets.neighbour < 0)
        self.nodes = field.facets.boundary
        sides = field.points[self.nodes[:, 1:]] - field.points[self.nodes[:, :1]]
        if field.dimension == 2:
            normal = np.cross(sides[:, 0], [0.0, 0.0, 1.0])
        else:
            normal = np.cross(sides[:, 0], sides[:, 1])
        inwards = field.points[field.facets.inside] - field.points[self.nodes[:, 0]]
        outward = np.where(np.einsum("bi,bi->b", normal, inwards) > 0.0, -1.0, 1.0)
        self.normal = normal * (outward / np.linalg.norm(normal, axis=1))[:, None]
        speed = np.linalg.norm(field.velocity, axis=1)
        across = np.einsum("bki,bi->bk", field.velocity[self.nodes], self.normal)
        local = speed[field.cells[self.cell]].max(axis=1)
        self.leaving = across.mean(axis=1) / np.where(local > 0.0, local, 1.0)
        self.number = np.full(field.cells.shape, -1, dtype=np.int64)
        self.number[self.cell, self.corner] = np.arange(len(self.cell))
        rests = (speed[self.nodes] <= STILL * speed.max()).all(axis=1)
        self.is_still = np.zeros(len(field.points), dtype=bool)
        self.is_still[self.nodes[rests]] = True

    def end(self, line: Path, reach: float) -> PathEnd:
        """Return why a line ended."""
        if line.end == "late":
            return "time"
        if line.end == "left":
            facet = self._crossed(line.position[-1], line.direction[-1], int(line.cell[-1]), reach)
            if facet is not None:
                return "outlet" if self.leaving[facet] > OPEN else "wall"
        stands = self.is_still[self.field.cells[line.cell[-1]]].any()
        return "wall" if stands else "stagnation"

    def is_cut(self, line: Path, reach: float) -> bool:
        """Tell whether a line has left to where the field has no numbers."""
        if line.end != "left" or not np.any(self.field.cut):
            return False
        facet = self._crossed(line.position[-1], line.direction[-1], int(line.cell[-1]), reach)
        cut = np.asarray(self.field.cut)
        return facet is not None and bool(cut[self.nodes[facet]].all())

    def _crossed(self, point: Array, way: Array, cell: int, reach: float) -> int | None:
        """Return the boundary facet that a ray crosses first; None if not within its reach."""
        d = self.field.dimension
        for _ in range(len(self.cell)):
            corner = self.field.points[self.field.cells[cell], :d]
            sides = (corner[1:] - corner[0]).T
            at, rate = np.linalg.solve(sides, np.stack([point[:d] - corner[0], way[:d]], axis=1)).T
            at, rate = np.r_[1.0 - at.sum(), at], np.r_[-rate.sum(), rate]
            left = np.where(rate < 0.0, at / np.where(rate < 0.0, -rate, 1.0), np.inf)
            out = int(np.argmin(left))
            if left[out] > reach:
                return None
            if self.number[cell, out] >= 0:
                return int(self.number[cell, out])
            cell = int(self.field.facets.neighbour[cell, out])
        return None


def _cut(field: Field, point: Array, normal: Array) -> tuple[Index, Array]:
    """Return the pieces of a plane (a line in two dimensions) in the cells.

    The cell of each, and its corners' barycentric coordinates there (f, d, d + 1). Nodes in the
    plane count as above it: a facet in it belongs to the cell below, or to the one above at the
    boundary.
    """
    level = (field.points - point) @ normal
    extent = float(np.max(field.bounds[1] - field.bounds[0]))
    level[np.abs(level) <= FLAT * extent] = 0.0
    height = level[field.cells]
    above = height >= 0.0
    count = above.sum(axis=1)
    d = field.dimension
    ranked = np.argsort(above, axis=1, kind="stable")  # those below come first

    def edge(rows: Index, i: Index, j: Index) -> Array:
        """Return the coordinates of the points at which edges from i to j cross the plane."""
        here = np.arange(len(rows))
        first, second = height[rows, i], height[rows, j]
        part = first / (first - second)
        weights = np.zeros((len(rows), d + 1))
        weights[here, i], weights[here, j] = 1.0 - part, part
        return weights

    cells, pieces = [], []
    for number in range(1, d + 1):
        rows = np.flatnonzero(count == number)
        order = ranked[rows]
        if number in {1, d}:  # one corner alone on its side
            order = np.roll(order, 1, axis=1) if number == 1 else order
            groups = [[(0, k) for k in range(1, d + 1)]]
        else:  # two and two
            groups = [[(0, 2), (0, 3), (1, 3)], [(0, 2), (1, 3), (1, 2)]]
        for group in groups:
            cells.append(rows)
            corners = [edge(rows, order[:, i], order[:, j]) for i, j in group]
            pieces.append(np.stack(corners, axis=1))
    flat = level == 0.0
    on_edge = flat[field.facets.boundary].all(axis=1) & (level[field.facets.inside] > 0.0)
    cell, corner = (part[on_edge] for part in np.nonzero(field.facets.neighbour < 0))
    others = np.array([[j for j in range(d + 1) if j != i] for i in range(d + 1)])
    cells.append(cell)
    pieces.append(np.eye(d + 1)[others[corner]])
    return np.concatenate(cells), np.concatenate(pieces)


def _section(field: Field, cell: Index, weights: Array, normal: Array, where: str) -> Section:
    """Return a section from its pieces' cells, corners and normals (f, 3) or (3,)."""
    d = field.dimension
    if cell.size == 0:
        low, high = field.bounds
        msg = (
            f"paths.seeds: the field has no cells in {where}: it reaches from {_place(low)} to "
            f"{_place(high)} m"
        )
        raise ConfigError(msg)
    middles = [0.5 * (weights[:, i] + weights[:, j]) for i, j in combinations(range(d), 2)]
    nodes = np.concatenate([weights, np.stack(middles, axis=1)], axis=1)
    f, q = nodes.shape[:2]
    place = Place(np.repeat(cell, q), nodes.reshape(f * q, d + 1)[:, 1:])
    velocity = field.velocity_at(place).reshape(f, q, 3)
    density = np.einsum("fqi,fi->fq", velocity, np.broadcast_to(normal, (f, 3)))
    points = field.evaluate(field.points, place).reshape(f, q, 3)
    if field.geometry == "axisymmetric":
        density = density * (2.0 * np.pi * points[..., 1])
    section = Section(points[:, :d], density)
    if section.flux < 0.0:
        section = Section(section.points, -density)
    if not section.flux > 0.0:
        msg = f"paths.seeds: nothing flows through {where}: give a section across the flow"
        raise ConfigError(msg)
    return section


def _along(section: Section, fraction: Array) -> Array:
    """Return the points (k, 3) of a section in the plane which parts of the flux have passed.

    In a segment the flux is the cubic that the quadratic density integrates to, found by bisection.
    """
    begin, end, middle = section.density.T
    slope, bend = 0.5 * (4.0 * middle - 3.0 * begin - end), (2.0 * (begin + end) - 4.0 * middle) / 3
    passed = np.r_[0.0, np.cumsum(section.size * (begin + slope + bend))]
    asked = fraction * passed[-1]
    k = np.clip(np.searchsorted(passed, asked, side="right") - 1, 0, len(begin) - 1)
    rest = (asked - passed[k]) / section.size[k]
    low, high = np.zeros(len(asked)), np.ones(len(asked))
    for _ in range(54):  # bits of a float
        part = 0.5 * (low + high)
        short = part * (begin[k] + part * (slope[k] + part * bend[k])) < rest
        low, high = np.where(short, part, low), np.where(short, high, part)
    part = (0.5 * (low + high))[:, None]
    return np.asarray(section.points[k, 0] * (1.0 - part) + section.points[k, 1] * part)


def _samples(section: Section, count: int) -> tuple[Array, Array]:
    """Return at least ``count`` points of a section in space, and the flux that each stands for.

    Triangles are cut into equal ones, in proportion to what passes through each: none carries much
    more than its share.
    """
    carried = section.size * section.density[:, 3:].mean(axis=1)
    parts = np.ceil(np.sqrt(np.maximum(count * carried / carried.sum(), 1.0))).astype(np.int64)
    points, fluxes = [], []
    for number in np.unique(parts):
        rows = np.flatnonzero(parts == number)
        weights = _lattice(int(number))
        lam = weights[None, :, :]
        squares = lam * (2.0 * lam - 1.0)
        edges = [4.0 * lam[..., i] * lam[..., j] for i, j in combinations(range(3), 2)]
        shape = np.concatenate([squares, np.stack(edges, axis=-1)], axis=-1)[0]
        density = np.maximum(section.density[rows] @ shape.T, 0.0)
        total = density.sum(axis=1, keepdims=True)
        share = density / np.where(total > 0.0, total, 1.0)
        points.append((weights @ section.points[rows]).reshape(-1, 3))
        fluxes.append((np.maximum(carried[rows, None], 0.0) * share).ravel())
    return np.concatenate(points), np.concatenate(fluxes)


def _lattice(count: int) -> Array:
    """Return the centres (count**2, 3) of equal small triangles, in barycentric coordinates."""
    up = [(i, j) for i in range(count) for j in range(count - i)]
    down = [(i, j) for i in range(count - 1) for j in range(count - 1 - i)]
    first = np.array(
        [(i + 1 / 3, j + 1 / 3) for i, j in up] + [(i + 2 / 3, j + 2 / 3) for i, j in down]
    )
    first = first / count
    return np.column_stack([1.0 - first.sum(axis=1), first])


def _halved(field: Field, points: Array, flux: Array, count: int) -> Array:
    """Return the centres (count, 3) of parts of equal flux, halved again and again."""
    seeds = []
    waiting = [(points, flux, count)]
    while waiting:
        points, flux, count = waiting.pop()
        if count == 1:
            centre = flux @ points / flux.sum()
            if not field.locate(centre[None]).found[0]:  # the part is hollow
                centre = points[np.argmin(np.linalg.norm(points - centre, axis=1))]
            seeds.append(centre)
            continue
        first = count // 2
        mean = flux @ points / flux.sum()
        spread = flux @ (points - mean) ** 2
        # of equal extents the first, whatever the rounding
        axis = int(np.argmax(spread > (1.0 - 1e-6) * spread.max()))
        order = np.argsort(points[:, axis], kind="stable")
        points, flux = points[order], flux[order]
        passed = np.cumsum(flux)
        target = passed[-1] * first / count
        k = int(np.searchsorted(passed, target))
        beyond = passed[k] - target  # one sample lies on both sides
        near, far = flux[: k + 1].copy(), flux[k:].copy()
        near[-1], far[0] = flux[k] - beyond, beyond
        waiting.append((points[k:], far, count - first))
        waiting.append((points[: k + 1], near, first))
    return np.array(seeds)


def _line(field: Field, start: ArrayLike, stop: ArrayLike) -> tuple[Array, Array]:
    """Return the ends of a line, or refuse them."""
    a, b = _point(field, "paths.from", start), _point(field, "paths.to", stop)
    if np.array_equal(a, b):
        msg = f"paths.from and paths.to are both {_place(a)} m: a line has two ends"
        raise ConfigError(msg)
    return a, b


def _point(field: Field, name: str, point: ArrayLike) -> Array:
    """Return one point with three coordinates, or refuse it."""
    x = real_array(name, point)
    return np.asarray(_points(field, name, x[None] if x.ndim == 1 else x)[0])


def _points(field: Field, name: str, points: ArrayLike) -> Array:
    """Return points (k, 3) with three coordinates, or refuse them."""
    x = real_array(name, points)
    fits = x.ndim == 2 and len(x) > 0 and x.shape[1] in {field.dimension, 3}
    if not fits or not np.all(np.isfinite(x)):
        d = field.dimension
        msg = f"{name} = {np.asarray(points).tolist()}: must be points of {d} finite coordinates"
        raise ConfigError(msg)
    x = np.pad(x, ((0, 0), (0, 3 - x.shape[1])))
    if field.dimension == 2 and np.any(x[:, 2] != 0.0):
        msg = f"{name} = {np.asarray(points).tolist()}: the field is {field.geometry}, at z = 0"
        raise ConfigError(msg)
    return np.asarray(x)


def _refuse_swirl(field: Field, fastest: float) -> None:
    around = float(np.max(np.abs(field.velocity[:, 2])))
    if field.geometry == "axisymmetric" and around > STILL * fastest:
        msg = (
            f"paths: the axisymmetric flow turns about its axis at up to {around:.3g} m/s: paths "
            "would leave their meridian plane; give the flow in space"
        )
        raise ConfigError(msg)


def _refuse_seeds(field: Field, seeds: Seeds, place: Place, least: float) -> None:
    """Refuse seeds outside the field, and where the melt stands."""
    if not place.found.all():
        k = int(np.flatnonzero(~place.found)[0])
        low, high = field.bounds
        msg = (
            f"paths: {np.sum(~place.found)} of {len(seeds.points)} seeds lie outside the field or "
            f"where it has no numbers, the first of them seed {k + 1} at "
            f"{_place(seeds.points[k])} m; the field reaches from {_place(low)} to {_place(high)} m"
        )
        raise ConfigError(msg)
    speed = np.linalg.norm(field.velocity_at(place), axis=1)
    still = np.flatnonzero(speed <= least)
    if still.size:
        k = int(still[0])
        msg = (
            f"paths: {still.size} of {len(seeds.points)} seeds lie where the melt stands, the "
            f"first of them seed {k + 1} at {_place(seeds.points[k])} m ({speed[k]:.3g} m/s): "
            "move it off the wall"
        )
        raise ConfigError(msg)


def _place(point: Array) -> str:
    return f"({', '.join(f'{x:.4g}' for x in point)})"
