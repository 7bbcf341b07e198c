"""From a file of another solver to a `Field`: units, geometry, gradients, and what is left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from fibermelt.errors import ConfigError, legible, legible_path
from fibermelt.fields.clouds import joined
from fibermelt.fields.contents import Contents
from fibermelt.fields.field import Field, Geometry
from fibermelt.fields.mapping import (
    ASKED_UNITS,
    ROLES,
    FieldMap,
    length_scale,
    role_scale,
    stacked,
    taken_for,
)
from fibermelt.fields.readers import read_contents
from fibermelt.fields.recovery import recovered_gradient
from fibermelt.fields.simplices import (
    adjacency,
    boundary_nodes,
    facets,
    sharp_nodes,
    signed_sizes,
    used_only,
)
from fibermelt.units import parse_plane

__all__ = ["FieldContents", "describe_field", "read_field"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

FASTEST = 100.0
"""Speed of a melt [m/s] beyond which the unit is wrong, as in a study's other speeds."""

NO_SPEED = 3e8
"""Speed of light [m/s]: faster is nothing in any unit, but bytes in another order."""

SAME = 1e-9
"""Distance over the domain's size below which coordinates are the same."""

ON_PLANE = 1e-6
"""The same of nodes on a plane of symmetry or an axis: files round to seven digits."""

FLAT = 1e-12
"""Area or volume over the longest edge to its power below which a cell is degenerate: layers at a
wall reach 1e-8, rounding to seven digits leaves 1e-14 of it."""

SAME_VELOCITY = 1e-6
"""Over the highest speed: above, nodes move; below, two velocities are the same. Files round to
seven digits."""

TURNED = 0.5
"""Part of the difference to the recovered gradient that is left when the file's is transposed,
below which it stands transposed in the file."""

WEDGE = 0.1
"""Half the width of a wedge over its radius, at most: OpenFOAM's have 0.04."""

ABSOLUTE = (9e4, 1.1e5)
"""Lowest pressure [Pa] that makes it look absolute: an atmosphere."""


OF_CELLS = 2.0
"""Times the estimate of the gradient's error where velocities were led from cells to nodes: by
quadratics, whose error is of the order of the estimate, and comes on top of it."""


@dataclass(frozen=True, eq=False)
class _Raw:
    """A flow in SI on its way: nodes (n, d), simplices, velocity (n, d), gradient (n, d, d).

    And whether the velocity was taken from cells to the nodes.
    """

    points: Array
    cells: Index
    velocity: Array
    gradient: Array | None
    scalars: dict[str, Array]
    from_cells: bool = False

    def at(self, nodes: Index, cells: Index) -> _Raw:
        """Return the flow with some of its nodes, and these cells on them."""
        return _Raw(
            self.points[nodes],
            cells,
            self.velocity[nodes],
            None if self.gradient is None else self.gradient[nodes],
            {name: values[nodes] for name, values in self.scalars.items()},
            self.from_cells,
        )

    def with_cells(self, cells: Index) -> _Raw:
        """Return the flow on these cells, without the nodes that none of them has."""
        numbered, kept = used_only(cells, len(self.points))
        return self.at(kept, numbered)


@dataclass(frozen=True, eq=False)
class FieldContents:
    """What is in a file, and what is made of it, before anything is computed.

    Parameters
    ----------
    format : str
        Whose file it is.
    dimension : int
        2 (a plane) or 3.
    points, cells : int
        Nodes and cells in the file; no cells of points that are to be joined.
    arrays : tuple of dict
        Of each array ``name``, ``components``, ``range`` (lowest and highest value, of vectors of
        their length; None where no value is finite) and ``taken_for``, a role or None.
    bounds : tuple of tuple
        Lowest and highest coordinate along each axis, in the file's unit.
    units : dict
        "length" and each role that is taken to the unit in the file, None where it names none.
    times : tuple of float
        Times in the file.
    notes : tuple of str
        What is doubtful or was done, in words.
    """

    format: str
    dimension: int
    points: int
    cells: int
    arrays: tuple[dict[str, Any], ...]
    bounds: tuple[tuple[float, float], ...]
    units: dict[str, str | None]
    times: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "format": self.format,
            "dimension": self.dimension,
            "points": self.points,
            "cells": self.cells,
            "arrays": list(self.arrays),
            "bounds": [list(pair) for pair in self.bounds],
            "units": self.units,
            "times": list(self.times),
            "notes": list(self.notes),
        }

    def taken(self) -> dict[str, str]:
        """Return the names of what is taken, by role."""
        found: dict[str, list[str]] = {}
        for array in self.arrays:
            if array["taken_for"]:
                found.setdefault(array["taken_for"], []).append(array["name"])
        return {role: ", ".join(names) for role, names in found.items()}


def describe_field(path: str | Path, wanted: FieldMap | None = None) -> FieldContents:
    """Return what is in a file of another solver, and which array is taken for what.

    Raises
    ------
    ConfigError
        If the file cannot be read. What a study would have to say is in the notes.
    """
    wanted = wanted or FieldMap()
    contents, notes = _flattened(Path(path), read_contents(Path(path), wanted.time_step))
    width = contents.points.shape[1]
    roles: dict[str, str] = {}
    for role in ROLES:
        # one at a time: what one lacks does not hide the others
        others = {other: "none" for other in ROLES if other not in {role, "velocity"}}
        try:
            alone = FieldMap(**{**vars(wanted), **others})
            found, told = taken_for(contents, alone, width)
        except ConfigError as error:
            if role == "velocity":
                notes.append(str(error))
            continue
        roles |= {name: array for name, array in found.items() if name == role}
        notes += told
    units: dict[str, str | None] = {"length": contents.length_unit or None}
    for role, names in roles.items():
        first = names if names in contents.arrays else names.split(",")[0].strip()
        units[role] = contents.units.get(first) or None
    unnamed = [of for of in ("length", *ASKED_UNITS) if units.get(of, "") is None]
    if contents.names_units and unnamed:
        notes.append(f"the file names no unit of {', '.join(unnamed)}: a study has to")
    place = {
        part.strip(): role
        for role, names in roles.items()
        for part in ([names] if names in contents.arrays else names.split(","))
    }
    arrays = []
    for name, values in contents.arrays.items():
        with np.errstate(over="ignore"):
            size = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
        finite = size[np.isfinite(size)]
        arrays.append(
            {
                "name": name,
                "components": 1 if values.ndim == 1 else int(values.shape[1]),
                "range": [float(finite.min()), float(finite.max())] if finite.size else None,
                "taken_for": place.get(name),
            }
        )
    points = contents.points
    return FieldContents(
        format=contents.format,
        dimension=width,
        points=len(points),
        cells=contents.file_cells,
        arrays=tuple(arrays),
        bounds=tuple((float(np.nanmin(c)), float(np.nanmax(c))) for c in points.T),
        units=units,
        times=contents.times,
        notes=tuple(dict.fromkeys([*contents.notes, *notes])),
    )


def read_field(path: str | Path, wanted: FieldMap | None = None) -> Field:
    """Return the flow in a file of another solver, in SI, with its velocity gradient.

    Parameters
    ----------
    path : str or Path
        The file; of OpenFOAM the case's folder.
    wanted : FieldMap, optional
        What the file does not say itself.

    Raises
    ------
    ConfigError
        If the file cannot be read, or what it holds is no flow: its key, and the way out.
    """
    file, wanted = Path(path), wanted or FieldMap()
    contents, notes = _flattened(file, read_contents(file, wanted.time_step))
    notes = [*contents.notes, *notes]
    axis = _axis(contents, wanted)
    raw = _in_si(contents, wanted, notes)
    raw = _whole(file, raw, contents.cells, notes)
    if axis == "y":
        raw = _swapped(raw)
    for plane in wanted.mirror:
        raw = _mirrored(raw, *_plane(plane, raw, wanted, axis))
    dimension = raw.points.shape[1]
    geometry: Geometry = "axisymmetric" if axis else "planar" if dimension == 2 else "spatial"
    _refuse_fast(raw)
    return _field(raw, geometry, notes)


def _axis(contents: Contents, wanted: FieldMap) -> str:
    """Return the axis that the plane is turned about, none if it is not."""
    if wanted.axis not in {"", "x", "y", "none"}:
        msg = f'field.axis = "{legible(wanted.axis)}": must be "x", "y" or "none"'
        raise ConfigError(msg)
    axis = contents.axis if not wanted.axis else wanted.axis.replace("none", "")
    if axis and contents.points.shape[1] == 3:
        msg = f'field.axis = "{axis}": the field is spatial, only a plane is turned; leave it away'
        raise ConfigError(msg)
    return axis


def _flattened(path: Path, contents: Contents) -> tuple[Contents, list[str]]:
    """Return the contents with as many coordinates as the flow has directions."""
    points = contents.points
    finite = points[np.isfinite(points).all(axis=1)]
    if not len(finite):
        msg = f"field.file = {legible_path(path)}: has no points with coordinates that are numbers"
        raise ConfigError(msg)
    extent = finite.max(axis=0) - finite.min(axis=0)
    if not extent.max() > 0:
        msg = f"field.file = {legible_path(path)}: all {len(points)} points lie in one place"
        raise ConfigError(msg)
    if points.shape[1] == 2:
        return contents, []
    thin = np.flatnonzero(extent <= SAME * extent.max())
    if thin.size:
        kept = [k for k in range(3) if k != thin[-1]]
        flat = _without_direction(contents, kept)
        names = "xyz"[kept[0]] + "xyz"[kept[1]]
        told = [] if names == "xy" else [f"the plane's {names[0]}, {names[1]} are taken for x, y"]
        return flat, told
    if contents.cells is not None and contents.cells.shape[1] == 3:
        msg = (
            f"field.file = {legible_path(path)}: has triangles in space: a surface has no flow "
            "inside; export the domain, or a plane at a constant x, y or z"
        )
        raise ConfigError(msg)
    layer = _one_layer(contents)
    if layer:
        return layer, ["one layer of cells: read as planar"]
    wedge = _wedge(contents)
    if wedge:
        return wedge, ["one layer of cells between two planes through an axis: axisymmetric"]
    return contents, []


def _without_direction(contents: Contents, kept: list[int]) -> Contents:
    """Return the contents without one of three directions, vectors and gradients as well."""
    width = {3: kept, 9: [3 * i + j for i in kept for j in kept]}
    arrays = {
        name: values[:, width[values.shape[1]]]
        if values.ndim == 2 and values.shape[1] in width
        else values
        for name, values in contents.arrays.items()
    }
    return replace(contents, points=contents.points[:, kept], arrays=arrays)


def _one_layer(contents: Contents) -> Contents | None:
    """Return the plane of a flow that is planar on one layer of cells, as OpenFOAM has it."""
    points, cells = contents.points, contents.cells
    if cells is None:
        return None
    low, high = points.min(axis=0), points.max(axis=0)
    slack = ON_PLANE * (high - low).max()
    for axis in (2, 1, 0):
        at_low = points[:, axis] <= low[axis] + slack
        if not np.all(at_low | (points[:, axis] >= high[axis] - slack)):
            continue
        outer = facets(cells).boundary
        numbered, kept = used_only(outer[at_low[outer].all(axis=1)], len(points))
        arrays = {name: values[kept] for name, values in contents.arrays.items()}
        layer = replace(contents, points=points[kept], arrays=arrays, cells=numbered)
        return _without_direction(layer, [k for k in range(3) if k != axis])
    return None


def _wedge(contents: Contents) -> Contents | None:
    """Return one side of a thin wedge, as OpenFOAM has axisymmetric flows, turned about x.

    Cells hold the velocity in the middle plane, where the component across the radius vanishes.
    """
    points, cells = contents.points, contents.cells
    if cells is None:
        return None
    for axis, radial, across in permutations(range(3)):
        r, z = points[:, radial], points[:, across]
        size = float(r.max())
        slope = float(np.abs(z).max()) / size if size > 0 else np.inf
        if slope > WEDGE or np.abs(np.abs(z) - slope * r).max() > ON_PLANE * size:
            continue
        side = z >= 0
        outer = facets(cells).boundary
        numbered, kept = used_only(outer[side[outer].all(axis=1)], len(points))
        arrays = {name: values[kept] for name, values in contents.arrays.items()}
        flat = replace(contents, points=points[kept], arrays=arrays, cells=numbered)
        flat = _without_direction(flat, [axis, radial])
        # the radius itself, not its part along the middle plane
        return replace(flat, points=flat.points * [1.0, np.hypot(1.0, slope)], axis="x")
    return None


def _in_si(contents: Contents, wanted: FieldMap, notes: list[str]) -> _Raw:
    """Return the arrays that are taken, in SI, on all of the file's nodes."""
    width = contents.points.shape[1]
    roles, told = taken_for(contents, wanted, width)
    notes += told
    scale = length_scale(contents, wanted)
    assumed = ["lengths in m"] if scale.is_assumed else []
    speed = 1.0
    values: dict[str, Array] = {}
    for role, names in roles.items():
        widths = {"velocity": (width, 3), "gradient": (width**2, 9)}.get(role, (1,))
        array = stacked(contents, role, names, widths)
        scaled = role_scale(contents, wanted, role, names)
        if role == "velocity":
            speed = scaled.factor
        # what nobody names of a gradient follows from velocities and lengths
        factor = speed / scale.factor if role == "gradient" and scaled.is_assumed else scaled.factor
        values[role] = array * factor + scaled.offset
        if scaled.is_assumed and role != "gradient":
            assumed.append(f"{role} in {ROLES[role]}")
    if assumed:
        notes.append(f"the file names no units: {', '.join(assumed)} are assumed")
    velocity = values.pop("velocity")
    fastest = float(np.nanmax(np.abs(velocity), initial=0.0))
    if fastest > NO_SPEED:
        msg = (
            f"field.velocity: speeds of up to {fastest:.4g} m/s: the file is damaged, or written "
            "in another byte order; export it again"
        )
        raise ConfigError(msg)
    across = np.abs(velocity[:, width:])
    if across.size and np.nanmax(across, initial=0.0) > SAME * np.nanmax(np.abs(velocity)):
        notes.append(
            f"the velocity across the plane, up to {np.nanmax(across):.3g} m/s, is left out"
        )
    gradient = values.pop("gradient", None)
    if gradient is not None:
        side = round(np.sqrt(gradient.shape[1]))
        gradient = gradient.reshape(-1, side, side)[:, :width, :width]
    if "pressure" in values:
        values["pressure"] = values["pressure"] - wanted.pressure_zero
        lowest = float(np.nanmin(values["pressure"], initial=np.inf))
        if ABSOLUTE[0] < lowest < ABSOLUTE[1]:
            notes.append(
                f"the lowest pressure is {lowest:.6g} Pa: if it is absolute, say "
                'field.pressure_zero = "101325 Pa"'
            )
    named = {roles["velocity"], *(name.strip() for name in roles["velocity"].split(","))}
    return _Raw(
        np.asarray(contents.points, dtype=np.float64) * scale.factor,
        np.empty((0, width + 1), dtype=np.int64),
        velocity[:, :width],
        gradient,
        values,
        from_cells=bool(named & contents.from_cells),
    )


def _whole(path: Path, raw: _Raw, cells: Index | None, notes: list[str]) -> _Raw:
    """Return the flow on cells with an area or volume and numbers at every corner."""
    known = np.all(np.isfinite(np.hstack([raw.points, raw.velocity])), axis=1)
    for values in raw.scalars.values():
        known &= np.isfinite(values)
    if raw.gradient is not None:
        known &= np.isfinite(raw.gradient).all(axis=(1, 2))
    # nodes of surfaces and lines, which a file may have besides, are none of the flow's
    used = np.arange(len(known)) if cells is None else np.unique(cells)
    missing = int((~known[used]).sum())
    if missing:
        notes.append(
            f"{missing} of {len(used)} points have no value (NaN): the cells around them lie "
            "outside, paths end there"
        )
    if missing == len(used):
        msg = f"field.file = {legible_path(path)}: no point has a velocity that is a number"
        raise ConfigError(msg)
    if cells is None:
        nodes = np.flatnonzero(known)
        inner = raw.at(nodes, cells=np.empty((0, 0), dtype=np.int64))
        found, told = joined(inner.points)
        notes.append(told)
        return inner.with_cells(found)
    whole = known[cells].all(axis=1)
    edge = np.zeros(len(known))
    edge[cells[~whole]] = 1.0
    raw = replace(raw, scalars=raw.scalars | {"cut": edge})
    cells = cells[whole]
    corner = raw.points[cells]
    longest = np.zeros(len(cells))
    for i in range(cells.shape[1]):
        for j in range(i):
            longest = np.maximum(longest, np.linalg.norm(corner[:, i] - corner[:, j], axis=1))
    size = np.abs(signed_sizes(raw.points, cells))
    good = size > FLAT * longest ** (cells.shape[1] - 1)
    flat = int((~good).sum())
    if not good.any():
        what = f"all {flat} cells are degenerate" if flat else "no cell has values at its corners"
        msg = f"field.file = {legible_path(path)}: {what}: export the mesh again"
        raise ConfigError(msg)
    if flat:
        notes.append(f"{flat} of {len(good)} simplices are degenerate: left out")
    return _merged(raw.with_cells(cells[good]), notes)


def _merged(raw: _Raw, notes: list[str]) -> _Raw:
    """Return the flow with nodes made one that blocks, partitions or cells of their own repeat.

    Two facets in one place are one if the flow passes there: a node on them moves. Both sides of a
    wall are at rest on all of theirs.
    """
    n = len(raw.points)
    size = float((raw.points.max(axis=0) - raw.points.min(axis=0)).max())
    pairs = cKDTree(raw.points).query_pairs(SAME * size, output_type="ndarray")
    if not len(pairs):
        return raw
    place = _components(pairs, n)[raw.cells]
    opposite = facets(place, over_slivers=False).neighbour
    cell, corner = np.nonzero(opposite > np.arange(len(opposite))[:, None])
    other = opposite[cell, corner]
    k = raw.cells.shape[1]
    without = np.array([[j for j in range(k) if j != i] for i in range(k)])
    here = np.take_along_axis(raw.cells[cell], without[corner], axis=1)
    at = np.take_along_axis(place[cell], without[corner], axis=1)
    # the same places on the other cell
    there = np.empty_like(here)
    for column in range(k - 1):
        match = (place[other] == at[:, column, None]).argmax(axis=1)
        there[:, column] = raw.cells[other, match]
    fastest = float(np.linalg.norm(raw.velocity, axis=1).max())
    apart = np.linalg.norm(raw.velocity[here] - raw.velocity[there], axis=2).max(axis=1)
    speed = np.linalg.norm(raw.velocity[here], axis=2).max(axis=1)
    one = (apart <= SAME_VELOCITY * fastest) & (speed > SAME_VELOCITY * fastest)
    number = _components(np.column_stack([here[one].ravel(), there[one].ravel()]), n)
    first = np.full(n, n)
    np.minimum.at(first, number, np.arange(n))
    kept = first[number]
    count = int((kept != np.arange(n)).sum())
    if not count:
        return raw
    notes.append(f"{count} nodes that lie on others inside the flow are made one with them")
    return raw.with_cells(kept[raw.cells])


def _components(pairs: Index, count: int) -> Index:
    """Return a number for each of so many nodes, the same for those that pairs connect."""
    ones = np.ones(len(pairs), dtype=bool)
    joint = coo_array((ones, (pairs[:, 0], pairs[:, 1])), (count, count))
    return np.asarray(connected_components(joint, directed=False)[1], dtype=np.int64)


def _swapped(raw: _Raw) -> _Raw:
    """Return a flow turned about y as one turned about x: axis first, radius second."""
    turn = [1, 0]
    gradient = None if raw.gradient is None else raw.gradient[:, turn][:, :, turn]
    return replace(
        raw, points=raw.points[:, turn], velocity=raw.velocity[:, turn], gradient=gradient
    )


def _plane(text: str, raw: _Raw, wanted: FieldMap, axis: str) -> tuple[int, float, str]:
    """Return direction, place and text of a plane of symmetry such as ``y`` or ``y = 2 mm``."""
    try:
        direction, place = parse_plane(text)
    except ConfigError as error:
        msg = f'field.mirror = "{legible(text)}": {error}'
        raise ConfigError(msg) from error
    if direction >= raw.points.shape[1]:
        msg = f'field.mirror = "{legible(text)}": the field is planar, it has no z'
        raise ConfigError(msg)
    if axis and direction == "xy".index("y" if axis == "x" else "x"):
        msg = (
            f'field.mirror = "{legible(text)}": the field is turned about {axis}, it is whole '
            "around it; leave the plane away"
        )
        raise ConfigError(msg)
    return 1 - direction if axis == "y" else direction, place, text


def _mirrored(raw: _Raw, direction: int, place: float, text: str = "") -> _Raw:
    """Return a flow and its mirror image, joined at the plane between them.

    Raises
    ------
    ConfigError
        If it does not end at the plane.
    """
    away = raw.points[:, direction] - place
    size = float((raw.points.max(axis=0) - raw.points.min(axis=0)).max())
    on_plane = np.abs(away) <= ON_PLANE * size
    low, high = float(away.min()), float(away.max())
    if min(-low, high) > ON_PLANE * size or not on_plane.any():
        msg = (
            f'field.mirror = "{legible(text)}": the field goes from {low + place:.4g} m to '
            f"{high + place:.4g} m there, it must end at {place:.4g} m"
        )
        raise ConfigError(msg)
    n = len(raw.points)
    other = np.flatnonzero(~on_plane)
    image = np.arange(n)
    image[other] = n + np.arange(len(other))
    sign = np.ones(raw.points.shape[1])
    sign[direction] = -1.0
    points = raw.points.copy()
    points[on_plane, direction] = place
    reflected = points[other] * sign
    reflected[:, direction] += 2 * place
    gradient = raw.gradient
    if gradient is not None:
        gradient = np.concatenate([gradient, gradient[other] * sign[:, None] * sign])
    return _Raw(
        np.concatenate([points, reflected]),
        np.concatenate([raw.cells, image[raw.cells]]),
        np.concatenate([raw.velocity, raw.velocity[other] * sign]),
        gradient,
        {name: np.concatenate([v, v[other]]) for name, v in raw.scalars.items()},
        raw.from_cells,
    )


def _refuse_fast(raw: _Raw) -> None:
    """Refuse speeds that no melt has: a unit that is another one than was taken for it."""
    fastest = float(np.linalg.norm(raw.velocity, axis=1).max())
    if fastest > FASTEST:
        msg = (
            f"field.velocity_unit: speeds of up to {fastest:.4g} m/s are not those of a melt (at "
            f'most {FASTEST:g}): say the unit, such as field.velocity_unit = "mm/s"'
        )
        raise ConfigError(msg)
    if fastest == 0.0:
        msg = "field.velocity: is zero everywhere: name another array, field.velocity"
        raise ConfigError(msg)


def _field(raw: _Raw, geometry: Geometry, notes: list[str]) -> Field:
    """Return the field with its gradient, what it may be wrong by, and what lies near a wall."""
    n, d = raw.points.shape
    around = raw
    if geometry == "axisymmetric":
        radius = raw.points[:, 1]
        size = float((raw.points.max(axis=0) - raw.points.min(axis=0)).max())
        if radius.min() < -ON_PLANE * size:
            msg = (
                f"field.axis: the radius goes down to {radius.min():.4g} m, must not be below 0: "
                "export one half of the section"
            )
            raise ConfigError(msg)
        if radius.min() <= ON_PLANE * size:
            # nodes on the axis are no boundary: the flow goes on behind it
            around = _mirrored(raw, 1, 0.0)
            raw = around.at(np.arange(n), raw.cells)
    slope, doubt = recovered_gradient(around.points, around.cells, around.velocity)
    slope, doubt = slope[:n], doubt[:n] * (OF_CELLS if raw.from_cells else 1.0)
    if raw.gradient is not None:
        slope, apart = _from_file(raw.gradient, slope, notes)
        # between nodes the file's is no better known than the recovered one
        doubt = np.maximum(doubt, apart)
    whole = np.zeros((n, 3, 3))
    whole[:, :d, :d] = slope
    share = 2 if geometry == "planar" else 3
    if geometry == "axisymmetric":
        radius = raw.points[:, 1]
        near_axis = radius <= ON_PLANE * radius.max()
        whole[:, 2, 2] = slope[:, 1, 1]
        whole[~near_axis, 2, 2] = raw.velocity[~near_axis, 1] / radius[~near_axis]
    divergence = np.trace(whole, axis1=1, axis2=2)
    whole[:, range(share), range(share)] -= divergence[:, None] / share
    found = facets(around.cells)
    at_wall = boundary_nodes(around.points, around.cells, found)
    sharp = np.zeros(len(around.points), dtype=bool)
    sharp[sharp_nodes(around.points, found)] = True
    sharp &= at_wall
    joint = adjacency(around.cells, len(around.points))
    doubt = np.hypot(doubt, _between_nodes(joint[:n, :n], ~at_wall[:n], whole))
    near_edge = np.asarray(joint @ (joint @ sharp.astype(np.int32)) > 0)
    return Field(
        geometry=geometry,
        points=np.column_stack([raw.points, np.zeros((n, 3 - d))]),
        cells=raw.cells,
        velocity=np.column_stack([raw.velocity, np.zeros((n, 3 - d))]),
        gradient=whole,
        gradient_error=doubt,
        divergence=divergence,
        pressure=raw.scalars.get("pressure"),
        viscosity=raw.scalars.get("viscosity"),
        temperature=raw.scalars.get("temperature"),
        near_wall=(at_wall | near_edge)[:n],
        near_edge=near_edge[:n],
        cut=raw.scalars["cut"] > 0.0 if "cut" in raw.scalars else None,
        notes=tuple(dict.fromkeys(notes)),
    )


def _between_nodes(joint: csr_array, inner: NDArray[np.bool_], gradient: Array) -> Array:
    """Return what a gradient that is linear between nodes misses there [1/s], estimated.

    A quadratic differs from the mean of its neighbours by twice what it bends between two nodes;
    a node on the boundary, whose neighbours lie on one side, has the largest of theirs.
    """
    n = len(gradient)
    flat = gradient.reshape(n, 9)
    count = np.maximum(np.asarray(joint.sum(axis=1)).ravel(), 1.0)
    bend = 0.5 * np.linalg.norm(flat - (joint @ flat) / count[:, None], axis=1)
    bend[~inner] = 0.0
    lent = np.asarray(joint.multiply(bend[None, :]).tocsr().max(axis=1).toarray()).ravel()
    return np.where(inner, bend, lent)


def _from_file(given: Array, slope: Array, notes: list[str]) -> tuple[Array, Array]:
    """Return the file's gradient and how far the recovered one is from it; turned if need be."""
    straight = np.linalg.norm(given - slope, axis=(1, 2))
    turned = np.linalg.norm(given.swapaxes(1, 2) - slope, axis=(1, 2))
    if np.median(turned) < TURNED * np.median(straight):
        notes.append(
            "the file's gradient is that of L[j, i] = du_i/dx_j: transposed, as velocities show"
        )
        given, straight = given.swapaxes(1, 2), turned
    size = float(np.median(np.linalg.norm(slope, axis=(1, 2))))
    if np.median(straight) > TURNED * size:
        notes.append(
            f"the file's gradient differs from that of its velocities by "
            f"{float(np.median(straight)):.3g} 1/s in the median, of {size:.3g}: check its unit, "
            'or say field.gradient = "none"'
        )
    return given, straight
