"""Cells of any kind are cut into simplices that fill them once and meet at whole facets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import pyvista
from dialects import Sample, cgns, openfoam, sample, vtu
from exact_flows import COUETTE, ROTATION, SLIT, ExactFlow, box
from square import square_field
from vtkmodules.vtkIOExodus import vtkExodusIIWriter
from vtkmodules.vtkIOHDF import vtkHDFWriter
from vtkmodules.vtkIOXdmf2 import vtkXdmfWriter

from fibermelt.errors import ConfigError
from fibermelt.fields.mapping import FieldMap
from fibermelt.fields.reading import describe_field, read_field
from fibermelt.fields.simplices import facets, signed_sizes
from fibermelt.fields.splitting import split_cells, split_polygons, split_polyhedra
from fibermelt.flow.vtu import write_vtu

N = 3
"""Bricks along each side."""


def bricks(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a unit cube in bricks: nodes in random order, hexahedra as VTK numbers them."""
    axis = np.linspace(0, 1, N + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(N + 1, N + 1, N + 1)
    corner = [(i, j, k) for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    cells = np.stack([number[i : i + N, j : j + N, k : k + N] for i, j, k in corner], axis=-1)
    order = np.random.default_rng(seed).permutation(len(points))
    moved = np.empty_like(points)
    moved[order] = points
    return moved, order[cells.reshape(-1, 8)]


SIDES = [[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]]
WEDGES = [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]
PYRAMIDS = [[*side, 8] for side in SIDES]
"""A hexahedron's faces, and what it is cut into; 8 is a node in its middle."""


def grids(seed: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the cube in tetrahedra cut from bricks, wedges and pyramids."""
    points, hexahedra = bricks(seed)
    middles = points[hexahedra].mean(axis=1)
    with_middle = np.column_stack([hexahedra, len(points) + np.arange(len(hexahedra))])
    voxels = hexahedra[:, [0, 1, 3, 2, 4, 5, 7, 6]]
    cut = {
        "hexahedra": (points, split_cells(12, hexahedra)),
        "voxels": (points, split_cells(11, voxels)),
        "wedges": (points, split_cells(13, hexahedra[:, WEDGES].reshape(-1, 6))),
        "pyramids": (
            np.concatenate([points, middles]),
            split_cells(14, with_middle[:, PYRAMIDS].reshape(-1, 5)),
        ),
    }
    nodes = hexahedra[:, SIDES].reshape(-1)
    owner = np.repeat(np.arange(len(hexahedra)), 6)
    cut["polyhedra"] = (points, split_polyhedra(nodes, np.arange(0, len(nodes) + 1, 4), owner))
    return cut


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["hexahedra", "voxels", "wedges", "pyramids", "polyhedra"])
def test_solids_are_filled_once_and_meet(kind: str, seed: int) -> None:
    points, cells = grids(seed)[kind]
    size = np.abs(signed_sizes(points, cells))
    assert size.min() > 1e-3 / N**3
    assert size.sum() == pytest.approx(1.0)
    found = facets(cells)
    on_side = np.isclose(points[found.boundary][..., None], [0.0, 1.0]).all(axis=1)
    assert on_side.any(axis=(1, 2)).all()  # no facet inside is without its neighbour
    assert len(found.boundary) == 6 * 2 * N**2


def test_tetrahedra_of_second_order_are_cut_at_their_nodes() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    edges = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
    points = np.concatenate([corners, [(corners[a] + corners[b]) / 2 for a, b in edges]])
    for kind in (24, 71):
        cells = split_cells(kind, np.arange(10)[None])
        np.testing.assert_allclose(np.abs(signed_sizes(points, cells)), 1 / 48)
        assert len(facets(cells).boundary) == 16


def test_hexahedra_of_second_order_are_cut_at_their_nodes() -> None:
    grid = pyvista.examples.cells.TriQuadraticHexahedron()
    points = np.asarray(grid.points, dtype=float)
    cells = split_cells(29, np.arange(27)[None])
    assert len(cells) == 48
    assert np.abs(signed_sizes(points, cells)).sum() == pytest.approx(np.ptp(points[:, 0]) ** 3)
    assert set(cells.ravel()) == set(range(27))
    assert len(facets(cells).boundary) == 48


@pytest.mark.parametrize(("kind", "count", "parts"), [(9, 4, 2), (8, 4, 2), (23, 8, 6), (28, 9, 8)])
def test_quadrilaterals(kind: int, count: int, parts: int) -> None:
    points = np.array(
        [[0.0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0], [1, 0.5], [0.5, 1], [0, 0.5], [0.5, 0.5]]
    )
    nodes = np.arange(count)[None]
    if kind == 8:
        points = points[[0, 1, 3, 2]]
    cells = split_cells(kind, nodes)
    assert len(cells) == parts
    assert np.abs(signed_sizes(points, cells)).sum() == pytest.approx(1.0)
    assert set(cells.ravel()) == set(range(count))


def test_collapsed_cells_leave_nothing_flat() -> None:
    """A hexahedron with two pairs of corners in one is a wedge."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1]])
    cells = split_cells(12, np.array([[0, 1, 2, 2, 3, 4, 5, 5]]))
    assert np.abs(signed_sizes(points, cells)).sum() == pytest.approx(0.5)


def test_polygons_and_what_is_no_cell() -> None:
    hexagon = np.array([[np.cos(a), np.sin(a)] for a in np.pi / 3 * np.arange(6)])
    cells = split_polygons([np.arange(6), np.array([0, 1])])
    assert len(cells) == 4
    assert np.abs(signed_sizes(hexagon, cells)).sum() == pytest.approx(1.5 * np.sqrt(3))
    assert split_cells(3, np.array([[0, 1]])) is None


def saved(path: Path, grid: pyvista.UnstructuredGrid, flow: ExactFlow) -> Path:
    points = np.asarray(grid.points, dtype=float)
    grid.point_data["velocity"] = flow.velocity(points)
    grid.point_data["p"] = flow.pressure(points)
    grid.save(path)
    return path


def test_a_mixed_grid_is_read(tmp_path: Path) -> None:
    points, hexahedra = bricks(1)
    split = hexahedra[: N**2]
    rest = hexahedra[N**2 :]
    grid = pyvista.UnstructuredGrid(
        {
            pyvista.CellType.HEXAHEDRON: rest,
            pyvista.CellType.WEDGE: split[:, WEDGES].reshape(-1, 6),
        },
        points,
    )
    path = saved(tmp_path / "mixed.vtu", grid, ROTATION)
    assert describe_field(path).cells == N**3 + N**2
    field = read_field(path)
    assert np.abs(signed_sizes(field.points, field.cells)).sum() == pytest.approx(1.0)
    error = np.linalg.norm(field.gradient - ROTATION.gradient(field.points), axis=(1, 2))
    assert error.max() < 1e-8
    inner = np.all((field.points > 0.01) & (field.points < 0.99), axis=1)
    np.testing.assert_array_equal(field.near_wall, ~inner)


def test_polyhedra_are_read(tmp_path: Path) -> None:
    points, hexahedra = bricks(2)
    cells = []
    for cell in hexahedra:
        body = [6]
        for face in SIDES:
            body += [4, *cell[face].tolist()]
        cells += [len(body), *body]
    grid = pyvista.UnstructuredGrid(cells, [42] * len(hexahedra), points)
    field = read_field(saved(tmp_path / "poly.vtu", grid, ROTATION))
    assert np.abs(signed_sizes(field.points, field.cells)).sum() == pytest.approx(1.0)


def test_corners_of_other_cells_are_read_and_told(tmp_path: Path) -> None:
    grid = pyvista.examples.cells.QuadraticHexahedron()
    path = saved(tmp_path / "quadratic.vtu", grid, ROTATION)
    field = read_field(path)
    assert "of cells of higher order the corners are read" in field.notes
    assert len(field.points) == 8


@pytest.mark.parametrize("suffix", [".vtk", ".vti", ".vtr", ".vts", ".vtm", ".vtp"])
def test_grids_of_other_kinds_are_read(tmp_path: Path, suffix: str) -> None:
    if suffix == ".vtp":
        grid = pyvista.Plane(center=(1, 0.5, 0), i_size=2, j_size=1, i_resolution=8, j_resolution=4)
        flow = SLIT
    else:
        flow = ROTATION
        grid = pyvista.ImageData(dimensions=(5, 5, 5), spacing=(0.25, 0.25, 0.25))
        if suffix == ".vtr":
            grid = grid.cast_to_rectilinear_grid()
        elif suffix != ".vti":
            grid = grid.cast_to_structured_grid()
    points = np.asarray(grid.points, dtype=float)
    grid.point_data["U"] = flow.velocity(points)
    data = pyvista.MultiBlock({"fluid": grid, "empty": None}) if suffix == ".vtm" else grid
    data.save(tmp_path / f"grid{suffix}")
    field = read_field(tmp_path / f"grid{suffix}")
    error = np.linalg.norm(field.gradient - flow.gradient(field.points), axis=(1, 2))
    assert error.max() < 1e-4  # of a plane the points are floats of four bytes


WRITERS = {
    "Exodus": (vtkExodusIIWriter, "a.e"),
    "XDMF": (vtkXdmfWriter, "a.xdmf"),
    "VTK HDF": (vtkHDFWriter, "a.vtkhdf"),
}


@pytest.mark.parametrize("format_", WRITERS)
def test_formats_that_vtk_writes(tmp_path: Path, format_: str) -> None:
    grid = pyvista.read(vtu(tmp_path, sample(ROTATION, 4)))
    grid.set_active_vectors("U")  # or VTK's writer of XDMF does not say that it is a vector
    grid.set_active_scalars("p")
    make, name = WRITERS[format_]
    writer = make()
    writer.SetFileName(str(tmp_path / name))
    writer.SetInputData(grid)
    writer.Write()
    path = (tmp_path / name).rename(tmp_path / "flow.out") if format_ != "XDMF" else tmp_path / name
    found = describe_field(path)
    assert found.format == format_
    assert found.taken() == {"velocity": "U", "pressure": "p"}
    field = read_field(path)
    error = np.linalg.norm(field.gradient - ROTATION.gradient(field.points), axis=(1, 2))
    assert error.max() < 1e-5  # some write coordinates in four bytes


@pytest.mark.parametrize("order", [2, 4])
def test_our_own_flow_keeps_its_nodes(tmp_path: Path, order: int) -> None:
    """Lagrange triangles of any order with the gradient beside; curved edges become chords."""
    ours = square_field(order, n=4, bend=0.1)
    write_vtu(ours, tmp_path / "flow.vtu")
    found = describe_field(tmp_path / "flow.vtu")
    assert (found.points, found.cells) == (len(ours.points), 32)
    assert found.taken()["gradient"] == "velocity_gradient"
    assert found.taken()["viscosity"] == "viscosity"
    field = read_field(tmp_path / "flow.vtu")
    assert len(field.cells) == 32 * order**2
    np.testing.assert_array_equal(field.points[:, :2], ours.points)
    np.testing.assert_allclose(field.gradient[:, :2, :2], ours.gradient, atol=1e-12)
    at = np.array([[0.3, 0.4], [0.7, 0.2]])
    theirs = field.velocity_at(field.locate(at))[:, :2]
    np.testing.assert_allclose(theirs, ours.evaluate(ours.velocity, ours.locate(at)), atol=1e-12)


def test_a_collection_of_times(tmp_path: Path) -> None:
    data = sample(SLIT, 4)
    sets = ""
    for k, factor in enumerate((1.0, 3.0)):
        scaled = Sample(data.mesh, factor * data.velocity, data.pressure)
        vtu(tmp_path, scaled, name=f"{k}.vtu")
        sets += f'<DataSet timestep="{k / 2}" part="0" file="{k}.vtu"/>'
    head = '<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">'
    path = tmp_path / "run.pvd"
    path.write_text(f'<?xml version="1.0"?>{head}<Collection>{sets}</Collection></VTKFile>')
    assert describe_field(path).times == (0.0, 0.5)
    assert read_field(path).velocity.max() == pytest.approx(4.5)
    assert read_field(path, FieldMap(time_step=0.0)).velocity.max() == pytest.approx(1.5)
    with pytest.raises(ConfigError, match=r"has no such time; it has 0, 0.5"):
        read_field(path, FieldMap(time_step=0.1))


def test_cgns(tmp_path: Path) -> None:
    path = cgns(tmp_path, sample(ROTATION, 4)).rename(tmp_path / "flow")
    found = describe_field(path)
    assert (found.format, found.points, found.cells) == ("CGNS", 125, 384)
    field = read_field(path)
    error = np.linalg.norm(field.gradient - ROTATION.gradient(field.points), axis=(1, 2))
    assert error.max() < 1e-5  # coordinates may be read in four bytes
    assert field.pressure is not None


def test_openfoam_in_space_and_on_one_layer(tmp_path: Path) -> None:
    case = openfoam(tmp_path / "cube", ROTATION, (5, 5, 5))
    (case / "cube.foam").touch()
    for path in (case, case / "cube.foam", case / "system" / "controlDict"):
        found = describe_field(path)
        assert (found.format, found.dimension, found.cells) == ("OpenFOAM", 3, 125)
        assert found.times == (0.5, 1.0)
    field = read_field(case)
    assert np.abs(signed_sizes(field.points, field.cells)).sum() == pytest.approx(1.0)
    error = np.linalg.norm(field.gradient - ROTATION.gradient(field.points), axis=(1, 2))
    assert error.max() < 1e-5  # its coordinates have four bytes
    earlier = read_field(case, FieldMap(time_step=0.5))
    np.testing.assert_allclose(earlier.velocity, 0.5 * field.velocity, atol=1e-6)
    layer = read_field(openfoam(tmp_path / "layer", SLIT, (8, 8, 1)))
    assert layer.geometry == "planar"
    assert len(layer.points) == 81
    sheared = read_field(openfoam(tmp_path / "sheared", COUETTE, (8, 8, 1)))
    error = np.linalg.norm(sheared.gradient - COUETTE.gradient(sheared.points), axis=(1, 2))
    assert error.max() < 1e-5  # at its sides, too


def test_openfoams_walls_are_at_rest(tmp_path: Path) -> None:
    flow = ExactFlow(
        "closed",
        "spatial",
        box,
        lambda x: np.prod(np.sin(np.pi * x), axis=1)[:, None] * [1.0, 0.5, 0.2],
        lambda x: np.zeros((len(x), 3, 3)),
        lambda x: x[:, 0],
    )
    case = openfoam(tmp_path / "case", flow, (6, 6, 6), wall="type noSlip;")
    field = read_field(case)
    assert any("have the value there: U" in note for note in field.notes)
    at_wall = np.isclose(field.points[..., None], [0.0, 1.0]).any(axis=(1, 2))
    assert np.abs(field.velocity[at_wall]).max() == 0.0
    inside = np.abs(field.velocity - flow.velocity(field.points))[~at_wall]
    assert inside.max() < 0.1
    # led on from the cells they would slip
    slipping = read_field(openfoam(tmp_path / "other", flow, (6, 6, 6)))
    assert np.abs(slipping.velocity[at_wall]).max() > 1e-2


def test_openfoams_pressure_over_density(tmp_path: Path) -> None:
    case = openfoam(tmp_path / "case", ROTATION, (3, 3, 3), over=820.0)
    assert describe_field(case).units["pressure"] == "m^2/s^2"
    with pytest.raises(ConfigError, match="of a pressure over density"):
        read_field(case)
    assert read_field(case, FieldMap(pressure_unit="820 Pa")).pressure is not None
