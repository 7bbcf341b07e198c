"""Other solvers' files become fields: every dialect, names, units, geometry, and what is wrong."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import pyvista
from dialects import (
    DIALECTS,
    JOINED,
    Sample,
    cfdpost,
    fluent,
    sample,
    sectionwise,
    spreadsheet,
    starccm,
    vtu,
)
from exact_flows import (
    EXTENSION,
    FLOWS,
    PIPE,
    ROTATION,
    SLIT,
    TUBE,
    ExactFlow,
    Mesh,
    embedded,
    rectangle,
)
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

from fibermelt.errors import ConfigError
from fibermelt.fields.field import Field
from fibermelt.fields.mapping import FieldMap
from fibermelt.fields.paths import flux_seeds, inflow_section, point_seeds, trace_field
from fibermelt.fields.reading import describe_field, read_field
from fibermelt.fields.simplices import signed_sizes

ROUNDING = 1e-7
"""Twelve decimals in the file over edges of a tenth, and the fit's condition."""

PLANAR = [flow for flow in FLOWS if flow.geometry == "planar"]
SPATIAL = [ROTATION, PIPE]


def gradient_error(field: Field, flow: ExactFlow) -> float:
    """Return the largest error of the gradient."""
    return float(np.linalg.norm(field.gradient - flow.gradient(field.points), axis=(1, 2)).max())


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("flow", [*PLANAR[:2], *SPATIAL], ids=lambda flow: flow.name)
def test_every_dialect_brings_the_flow_back(tmp_path: Path, dialect: str, flow: ExactFlow) -> None:
    data = sample(flow, 5)
    field = read_field(DIALECTS[dialect](tmp_path, data))
    assert field.geometry == flow.geometry
    np.testing.assert_allclose(field.velocity, flow.velocity(field.points), atol=1e-11)
    assert field.pressure is not None
    np.testing.assert_allclose(field.pressure, flow.pressure(field.points), atol=1e-10)
    assert gradient_error(field, flow) < ROUNDING
    assert np.abs(field.divergence).max() < ROUNDING
    is_joined = dialect in JOINED or (dialect == "cfdpost" and flow.geometry == "spatial")
    assert any("points only" in note for note in field.notes) == is_joined
    if not is_joined:
        assert len(field.points) == len(data.mesh.points)
        assert len(field.cells) == len(data.mesh.cells)
    # every cell is in its place: the middle of each of the mesh is inside the field
    centres = embedded(data.mesh.points[data.mesh.cells].mean(axis=1))
    assert field.locate(centres).found.mean() > (0.98 if is_joined else 0.9999)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_suffixes_say_nothing(tmp_path: Path, dialect: str) -> None:
    path = DIALECTS[dialect](tmp_path, sample(SLIT, 4))
    other = path.rename(tmp_path / "data.bin")
    assert describe_field(other).dimension == 2


@pytest.mark.parametrize(
    ("write", "units"),
    [
        (cfdpost, ("mm", "mm s^-1", "kPa")),
        (spreadsheet, ("mm", "mm/s", "kPa")),
        (sectionwise, ("mm", "mm/s", "kPa")),
    ],
)
def test_units_of_the_file_are_used(tmp_path: Path, write, units: tuple[str, str, str]) -> None:
    data = sample(SLIT, 4, length=1e-3, speed=1e-3, pressure=1e3)
    path = write(tmp_path, data, units=units)
    field = read_field(path)
    np.testing.assert_allclose(field.velocity, SLIT.velocity(field.points), atol=1e-9)
    assert gradient_error(field, SLIT) < 1e-6
    np.testing.assert_allclose(field.pressure, SLIT.pressure(field.points), atol=1e-8)
    found = describe_field(path)
    assert found.units["length"] == "mm"
    assert found.units["velocity"] == units[1]
    # the same said again is no fault, another one is
    again = FieldMap(length_unit="mm", velocity_unit="mm/s", pressure_unit="kPa")
    assert np.array_equal(read_field(path, again).velocity, field.velocity)
    with pytest.raises(
        ConfigError, match=r'length_unit = "m": the file has its coordinates in "mm"'
    ):
        read_field(path, FieldMap(length_unit="m"))
    with pytest.raises(ConfigError, match=r'pressure_unit = "MPa": the file has its pressure in'):
        read_field(path, FieldMap(pressure_unit="MPa"))


def test_units_that_no_file_of_a_format_has_are_assumed_and_told(tmp_path: Path) -> None:
    data = sample(SLIT, 4, length=1e-3, speed=1e-3, pressure=1e6)
    path = fluent(tmp_path, data)
    with pytest.raises(ConfigError, match=r"velocity_unit: speeds of up to 1500 m/s"):
        read_field(path)
    wanted = FieldMap(length_unit="mm", velocity_unit="mm/s", pressure_unit="MPa")
    field = read_field(path, wanted)
    assert gradient_error(field, SLIT) < 1e-6
    assert not any("assumed" in note for note in field.notes)
    assumed = read_field(fluent(tmp_path, sample(SLIT, 4)))
    assert any("lengths in m, velocity in m/s, pressure in Pa" in note for note in assumed.notes)


def test_units_that_a_format_names_are_asked_for(tmp_path: Path) -> None:
    path = spreadsheet(tmp_path, sample(SLIT, 4))
    text = path.read_text()
    path.write_text(text.replace("% Length unit:        m\n", ""))
    with pytest.raises(ConfigError, match=r'field.length_unit: .* say it, such as .* = "m"'):
        read_field(path)
    assert "the file names no unit of length: a study has to" in describe_field(path).notes
    assert read_field(path, FieldMap(length_unit="m")).geometry == "planar"
    path.write_text(text.replace(" (m/s)", "      "))
    with pytest.raises(ConfigError, match=r"field.velocity_unit: the file names no unit"):
        read_field(path)
    path.write_text(text.replace("(m/s)", "(furl)"))
    with pytest.raises(ConfigError, match=r'unit "furl", which is not known: say field.velocity'):
        read_field(path)
    assert read_field(path, FieldMap(velocity_unit="m/s")).geometry == "planar"
    path.write_text(text.replace("v (m/s)", "v (cm/s)"))
    with pytest.raises(ConfigError, match=r'components are in "cm/s" and "m/s", must be in one'):
        read_field(path)


def test_a_pressure_over_density_is_asked_for_by_its_density(tmp_path: Path) -> None:
    path = spreadsheet(tmp_path, sample(SLIT, 4, pressure=820.0), units=("m", "m/s", "m^2/s^2"))
    with pytest.raises(ConfigError, match=r'over density, "820 Pa" with 820 kg/m3'):
        read_field(path)
    field = read_field(path, FieldMap(pressure_unit="820 Pa"))
    np.testing.assert_allclose(field.pressure, SLIT.pressure(field.points), atol=1e-8)


def test_an_absolute_pressure_is_told_and_shifted(tmp_path: Path) -> None:
    data = sample(SLIT, 4)
    path = fluent(tmp_path, Sample(data.mesh, data.velocity, data.pressure + 101325.0))
    field = read_field(path)
    assert any('field.pressure_zero = "101325 Pa"' in note for note in field.notes)
    field = read_field(path, FieldMap(pressure_zero=101325.0))
    assert not any("absolute" in note for note in field.notes)
    np.testing.assert_allclose(field.pressure, SLIT.pressure(field.points), atol=1e-6)


def test_fluent_with_blanks_and_at_centres_of_cells(tmp_path: Path) -> None:
    path = fluent(tmp_path, sample(SLIT, 4), between=" ")
    assert gradient_error(read_field(path), SLIT) < ROUNDING
    lines = path.read_text().splitlines()
    again = [f"{line} {'x-coordinate' if k == 0 else '0'}" for k, line in enumerate(lines)]
    path.write_text("\n".join(again))  # asked for as a variable, too
    assert describe_field(path).taken()["velocity"] == "x-velocity, y-velocity"
    assert [array["name"] for array in describe_field(path).arrays][-1] == "y-velocity"
    path.write_text(path.read_text().replace("nodenumber", "cellnumber"))
    assert any("centres of cells" in note for note in read_field(path).notes)


@pytest.mark.parametrize("flow", [TUBE, EXTENSION], ids=lambda flow: flow.name)
def test_a_plane_turned_about_an_axis(tmp_path: Path, flow: ExactFlow) -> None:
    data = sample(flow, 6)
    field = read_field(vtu(tmp_path, data), FieldMap(axis="x"))
    assert field.geometry == "axisymmetric"
    assert gradient_error(field, flow) < ROUNDING
    # the axis is no wall, the other three sides are boundary
    on_axis = (field.points[:, 1] == 0) & (field.points[:, 0] > 0) & (field.points[:, 0] < 2)
    assert not field.near_wall[on_axis].any()
    assert field.near_wall[field.points[:, 1] == 1].all()
    # the same as COMSOL has it, radius first, the axis up
    turned = Sample(
        Mesh(data.mesh.points[:, ::-1], data.mesh.cells), data.velocity[:, ::-1], data.pressure
    )
    comsol = read_field(spreadsheet(tmp_path, turned, axes="rz", letters="uw"))
    assert comsol.geometry == "axisymmetric"
    assert gradient_error(comsol, flow) < ROUNDING
    sections = read_field(sectionwise(tmp_path, turned), FieldMap(axis="y"))
    assert gradient_error(sections, flow) < ROUNDING


def test_half_a_domain_is_mirrored(tmp_path: Path) -> None:
    whole = rectangle(6)
    middle = whole.points[whole.cells].mean(axis=1)[:, 1] < 0.5
    points = whole.points.copy()
    level = np.abs(points[:, 1] - 0.5) < 0.04
    points[level, 1] = 0.5
    half = Mesh(points, whole.cells[middle])
    x = embedded(points)
    path = vtu(tmp_path, Sample(half, SLIT.velocity(x)[:, :2], SLIT.pressure(x)))
    field = read_field(path, FieldMap(mirror=("y = 0.5 m",)))
    assert field.points[:, 1].max() == pytest.approx(1.0)
    assert gradient_error(field, SLIT) < ROUNDING
    inner = (np.abs(field.points[:, 1] - 0.5) < 1e-9) & (np.abs(field.points[:, 0] - 1) < 0.9)
    assert inner.any()
    assert not field.near_wall[inner].any()
    for mirror, match in {
        "y": r'mirror = "y": the field goes from 0 m|mirror',
        "z": r'mirror = "z": the field is planar',
        "y = 3 s": "measures time, not length",
        "u": r'must be "x", "y" or "z"',
        "y = 0.25 m": r"it must end at 0.25 m",
    }.items():
        if mirror == "y":
            continue
        with pytest.raises(ConfigError, match=match):
            read_field(path, FieldMap(mirror=(mirror,)))
    with pytest.raises(ConfigError, match=r"turned about x, it is whole"):
        read_field(path, FieldMap(mirror=("y",), axis="x"))


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"velocity": 3}, "field.velocity is of the type int, must be str"),
        ({"mirror": ["y"]}, "field.mirror is of the type list, must be tuple"),
        ({"pressure_zero": "1 bar"}, "pressure_zero = .*: must be one number, in SI"),
        ({"time_step": "last"}, "time_step = .*: must be one number"),
    ],
)
def test_a_map_takes_names_and_numbers(given: dict[str, object], match: str) -> None:
    with pytest.raises(ConfigError, match=match):
        FieldMap(**given)


def test_keys_of_planes_are_refused_in_space(tmp_path: Path) -> None:
    path = vtu(tmp_path, sample(ROTATION, 3))
    with pytest.raises(ConfigError, match=r'field.axis = "x": the field is spatial'):
        read_field(path, FieldMap(axis="x"))
    with pytest.raises(ConfigError, match=r'field.axis = "w": must be'):
        read_field(path, FieldMap(axis="w"))


def test_a_section_that_spans_its_axis_is_refused(tmp_path: Path) -> None:
    data = sample(TUBE, 4)
    shifted = Sample(
        Mesh(data.mesh.points - np.array([0.0, 0.5]), data.mesh.cells), data.velocity, data.pressure
    )
    with pytest.raises(ConfigError, match=r"the radius goes down to -0.5 m"):
        read_field(vtu(tmp_path, shifted), FieldMap(axis="x"))


def test_the_gradient_of_the_file_is_taken_and_a_transposed_one_is_seen(tmp_path: Path) -> None:
    data = sample(SLIT, 5)
    exact = SLIT.gradient(embedded(data.mesh.points))
    for given in (exact, exact.swapaxes(1, 2)):
        path = vtu(tmp_path, data, velocity_gradient=given.reshape(-1, 9))
        field = read_field(path)
        assert gradient_error(field, SLIT) < 1e-12  # the file's, not the recovered one
        told = any("transposed" in note for note in field.notes)
        assert told == (given is not exact)
    wrong = read_field(vtu(tmp_path, data, velocity_gradient=1e3 * exact.reshape(-1, 9)))
    assert any("check its unit" in note for note in wrong.notes)
    assert np.median(wrong.gradient_error) > 1e3
    recovered = read_field(path, FieldMap(gradient="none"))
    assert 0 < gradient_error(recovered, SLIT) < ROUNDING


def test_a_gradient_without_unit_is_in_the_velocitys_over_the_lengths(tmp_path: Path) -> None:
    data = sample(SLIT, 5, length=1e-3)
    exact = SLIT.gradient(embedded(data.mesh.points * 1e-3))
    path = vtu(tmp_path, data, velocity_gradient=1e-3 * exact.reshape(-1, 9))
    field = read_field(path, FieldMap(length_unit="mm"))
    assert gradient_error(field, SLIT) < 1e-12


def test_components_of_a_gradient_by_their_names(tmp_path: Path) -> None:
    data = sample(SLIT, 4)
    L = SLIT.gradient(embedded(data.mesh.points))
    path = fluent(tmp_path, data)
    lines = path.read_text().splitlines()
    names = [f"d{u}-velocity-d{x}" for u in "xy" for x in "xy"]
    lines[0] += ", " + ", ".join(names)
    rows = [",".join(f"{value:.6g}" for value in row) for row in L[:, :2, :2].reshape(-1, 4)]
    lines[1:] = [f"{line},{row}" for line, row in zip(lines[1:], rows, strict=True)]
    path.write_text("\n".join(lines))
    found = describe_field(path).taken()
    assert found["gradient"] == ", ".join(names)
    assert found["velocity"] == "x-velocity, y-velocity"
    assert gradient_error(read_field(path), SLIT) < 1e-5  # six digits, below the recovered one's
    assert gradient_error(read_field(path), SLIT) > 0


def test_no_velocity_and_several(tmp_path: Path) -> None:
    data = sample(SLIT, 4)
    grid = pyvista.read(vtu(tmp_path, data))
    u = grid.point_data["U"].copy()
    path = tmp_path / "other.vtu"
    del grid.point_data["U"]
    grid.save(path)
    with pytest.raises(ConfigError, match=r'nothing in the file is called a velocity; it has "p"'):
        read_field(path)
    assert any("field.velocity" in note for note in describe_field(path).notes)
    grid.point_data["flux"] = u
    grid.save(path)
    with pytest.raises(ConfigError, match=r'"flux" \(2\); say field.velocity'):
        read_field(path)
    assert gradient_error(read_field(path, FieldMap(velocity="flux")), SLIT) < ROUNDING
    grid.point_data["U"] = u
    grid.point_data["velocity"] = u
    grid.save(path)
    with pytest.raises(ConfigError, match=r'the file has "U" or "velocity": say which'):
        read_field(path)
    assert read_field(path, FieldMap(velocity="U")).geometry == "planar"
    grid.point_data["Pressure"] = grid.point_data["p"]
    grid.save(path)
    with pytest.raises(ConfigError, match=r'field.pressure: the file has "p" or "Pressure"'):
        read_field(path, FieldMap(velocity="U"))
    with pytest.raises(ConfigError, match=r'field.velocity = "speed": the file has no "speed"; it'):
        read_field(path, FieldMap(velocity="speed"))
    with pytest.raises(ConfigError, match=r'velocity = "p": has 1 components, must have 2 or 3'):
        read_field(path, FieldMap(velocity="p", pressure="p"))


def test_nan_in_a_region_is_outside(tmp_path: Path) -> None:
    data = sample(SLIT, 10)
    hole = np.linalg.norm(data.mesh.points - [1.0, 0.5], axis=1) < 0.15
    velocity = np.where(hole[:, None], np.nan, data.velocity)
    field = read_field(vtu(tmp_path, Sample(data.mesh, velocity, data.pressure)))
    assert any(f"{hole.sum()} of {len(hole)} points have no value" in note for note in field.notes)
    inside = field.locate(np.array([[1.0, 0.5, 0.0], [0.5, 0.5, 0.0]]))
    np.testing.assert_array_equal(inside.found, [False, True])
    assert gradient_error(field, SLIT) < ROUNDING
    into, past = trace_field(field, point_seeds(field, [[0.0, 0.5], [0.0, 0.9]]), 50)
    assert into.cut
    assert "where the file has no numbers" in into.told[-1]
    assert not past.cut
    # of a table the word is another one
    path = cfdpost(tmp_path, Sample(data.mesh, velocity, data.pressure))
    path.write_text(path.read_text().replace("nan", "null"))
    assert len(read_field(path).points) == len(field.points)
    with pytest.raises(ConfigError, match="no point has a velocity that is a number"):
        read_field(vtu(tmp_path, Sample(data.mesh, velocity * np.nan, data.pressure)))


def test_degenerate_cells_are_left_out_or_refused(tmp_path: Path) -> None:
    data = sample(SLIT, 5)
    cells = np.concatenate([data.mesh.cells, [[0, 1, 2]]])  # three nodes of the bottom
    field = read_field(
        vtu(tmp_path, Sample(Mesh(data.mesh.points, cells), data.velocity, data.pressure))
    )
    assert "1 of 101 simplices are degenerate: left out" in field.notes
    flat = Mesh(data.mesh.points, np.array([[0, 1, 2], [2, 3, 4]]))
    with pytest.raises(ConfigError, match="all 2 cells are degenerate"):
        read_field(vtu(tmp_path, Sample(flat, data.velocity, data.pressure)))


def test_blocks_that_repeat_nodes_are_joined_and_walls_are_not(tmp_path: Path) -> None:
    low = rectangle(6)
    points = np.concatenate([low.points, low.points + np.array([2.0, 0.0])])
    mesh = Mesh(points, np.concatenate([low.cells, low.cells + len(low.points)]))
    x = embedded(points)
    field = read_field(vtu(tmp_path, Sample(mesh, SLIT.velocity(x)[:, :2], SLIT.pressure(x))))
    # the two at rest on the walls as well, from where the flow passes beside them
    assert any(note.startswith("7 nodes that lie on others") for note in field.notes)
    seam = (field.points[:, 0] == 2.0) & (np.abs(field.points[:, 1] - 0.5) < 0.4)
    assert seam.sum() == 5
    assert not field.near_wall[seam].any()


def test_cells_with_nodes_of_their_own_are_joined(tmp_path: Path) -> None:
    data = sample(SLIT, 6)
    nodes = data.mesh.cells.ravel()
    loose = Mesh(data.mesh.points[nodes], np.arange(len(nodes)).reshape(-1, 3))
    field = read_field(vtu(tmp_path, Sample(loose, data.velocity[nodes], data.pressure[nodes])))
    # of the corners two have a cell for which nothing moves on the edge to the next
    assert len(field.points) - len(data.mesh.points) in range(5)
    assert gradient_error(field, SLIT) < ROUNDING


def test_a_wall_without_thickness_stays(tmp_path: Path) -> None:
    """Two slits, one upon the other, with a wall between them that ends before the outlet."""
    low = rectangle(6)
    points = np.concatenate([low.points, low.points + np.array([0.0, 1.0])])
    cells = np.concatenate([low.cells, low.cells + len(low.points)])
    x = embedded(points)
    y = points[:, 1] % 1.0
    u = np.column_stack([6 * y * (1 - y), 0 * y])
    end = (np.abs(points[:, 1] - 1.0) < 1e-9) & (points[:, 0] > 1.7)
    u[end, 0] = 0.1
    field = read_field(vtu(tmp_path, Sample(Mesh(points, cells), u, x[:, 0])))
    # two nodes that move, and the one at rest where the wall ends
    assert any(note.startswith("3 nodes that lie on others") for note in field.notes)
    place = field.locate(np.array([[0.5, 0.99, 0], [0.5, 1.01, 0]]))
    corners = [set(field.cells[cell]) for cell in place.cell]
    assert not corners[0] & corners[1]


def test_values_of_cells_are_taken_to_points_and_told(tmp_path: Path) -> None:
    mesh = rectangle(8)
    grid = pyvista.UnstructuredGrid({pyvista.CellType.TRIANGLE: mesh.cells}, embedded(mesh.points))
    centres = embedded(mesh.points[mesh.cells].mean(axis=1))
    for k, name in enumerate(("SV_U", "SV_V")):
        grid.cell_data[name] = EXTENSION.velocity(centres)[:, k]
    # a node that belongs to no cell has no value, and is none of the flow's
    grid.points = np.vstack([grid.points, [[9.0, 9.0, 0.0]]])
    grid.save(tmp_path / "cells.vtu")
    field = read_field(tmp_path / "cells.vtu")
    assert not any("NaN" in note for note in field.notes)
    assert len(field.points) == len(mesh.points)
    assert any("values of cells are taken to the nodes" in note for note in field.notes)
    np.testing.assert_allclose(field.velocity, EXTENSION.velocity(field.points), atol=1e-10)
    assert field.pressure is None


def test_wrong_length_and_truncated(tmp_path: Path) -> None:
    for write in (fluent, cfdpost, starccm, spreadsheet, sectionwise):
        path = write(tmp_path, sample(SLIT, 4))
        text = path.read_text()
        path.write_text(text[: int(0.6 * len(text))])
        with pytest.raises(ConfigError, match=r"truncated or damaged; export it again"):
            read_field(path)
    path = spreadsheet(tmp_path, sample(SLIT, 4))
    path.write_text("\n".join(path.read_text().splitlines()[:-3]))
    with pytest.raises(ConfigError, match=r"has 42 nodes, but says that it has 45"):
        read_field(path)
    path = sectionwise(tmp_path, sample(SLIT, 4))
    text = path.read_text()
    path.write_text(text.replace("% Data (p (Pa))\n", "% Data (p (Pa))\n1.0\n"))
    with pytest.raises(ConfigError, match=r"has 46 values of p \(Pa\), but says that it has 45"):
        read_field(path)
    path = vtu(tmp_path, sample(SLIT, 4))
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(ConfigError, match=r"truncated, damaged"):
        read_field(path)


def test_decimal_commas_are_told(tmp_path: Path) -> None:
    path = fluent(tmp_path, sample(SLIT, 4), between=" ")
    path.write_text(path.read_text().replace(".", ","))
    with pytest.raises(ConfigError, match=r"line 2 has 12 values.* decimal commas are not read"):
        read_field(path)
    path = spreadsheet(tmp_path, sample(SLIT, 4))
    lines = path.read_text().splitlines()
    lines[9:] = [line.replace(".", ",") for line in lines[9:]]
    path.write_text("\n".join(lines))
    with pytest.raises(ConfigError, match=r"10 columns.* export it again, with decimal points"):
        read_field(path)


def test_what_is_no_number_is_told(tmp_path: Path) -> None:
    path = spreadsheet(tmp_path, sample(SLIT, 4))
    text = path.read_text().splitlines()
    text[-1] = text[-1].replace(" ", "abc ", 1)
    path.write_text("\n".join(text))
    with pytest.raises(ConfigError, match=r'line 54 has ".*abc", which is no number'):
        read_field(path)


def test_bytes_in_another_order_are_told(tmp_path: Path) -> None:
    data = sample(SLIT, 4)
    grid = pyvista.read(vtu(tmp_path, data))
    grid.points = grid.points.astype(">f8").view("<f8").astype(float)
    grid.points[np.isnan(grid.points)] = 0.0
    grid.save(tmp_path / "swapped.vtu")
    with pytest.raises(ConfigError, match=r"written in another byte order"):
        read_field(tmp_path / "swapped.vtu")
    swapped = data.velocity.astype(">f8").view("<f8").astype(float)
    path = vtu(tmp_path, Sample(data.mesh, np.nan_to_num(swapped), data.pressure))
    with pytest.raises(ConfigError, match=r"field.velocity: speeds of up to .* another byte order"):
        read_field(path)
    assert describe_field(path).arrays[0]["name"] == "U"


@pytest.mark.parametrize("byte_order", ["BigEndian", "LittleEndian"])
def test_a_byte_order_that_the_file_names_is_followed(tmp_path: Path, byte_order: str) -> None:
    path = vtu(tmp_path, sample(SLIT, 4))
    grid = pyvista.read(path)
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(grid)
    getattr(writer, f"SetByteOrderTo{byte_order}")()
    writer.Write()
    assert byte_order.encode() in path.read_bytes()[:400]
    assert gradient_error(read_field(path), SLIT) < ROUNDING


def test_no_pyvista_names_the_line_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = vtu(tmp_path, sample(SLIT, 4))
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(ConfigError, match=r'is read by pyvista.*pip install "fibermelt\[fields\]"'):
        read_field(path)
    # own readers do without
    assert read_field(fluent(tmp_path, sample(SLIT, 4))).geometry == "planar"


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("", "is empty"),
        ("hello\n", "is in no format that is known; known are COMSOL sectionwise"),
    ],
)
def test_files_of_no_known_format(tmp_path: Path, text: str, match: str) -> None:
    path = tmp_path / "a.vtu"
    path.write_text(text)
    with pytest.raises(ConfigError, match=match):
        read_field(path)
    with pytest.raises(ConfigError, match="cannot be read: no such file"):
        read_field(tmp_path / "none.vtu")
    with pytest.raises(ConfigError, match="is in no format"):
        read_field(tmp_path)


def test_a_damaged_hdf5_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.cas.h5"
    path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(200))
    with pytest.raises(ConfigError, match="cannot be read as HDF5: truncated, damaged"):
        read_field(path)


def test_a_time_of_a_file_without_times_is_told(tmp_path: Path) -> None:
    field = read_field(fluent(tmp_path, sample(SLIT, 4)), FieldMap(time_step=0.5))
    assert "field.time_step = 0.5 is not looked at: the file has one time" in field.notes


def test_points_that_a_file_has_twice_are_joined_once(tmp_path: Path) -> None:
    """Zones repeat the points between them: of each place one is a node."""
    data = sample(SLIT, 4)
    twice = np.concatenate([data.mesh.points, data.mesh.points[::3]])
    velocity = np.concatenate([data.velocity, data.velocity[::3]])
    pressure = np.concatenate([data.pressure, data.pressure[::3]])
    field = read_field(fluent(tmp_path, Sample(Mesh(twice, data.mesh.cells), velocity, pressure)))
    assert len(field.points) == len(data.mesh.points)
    assert np.abs(signed_sizes(field.points[:, :2], field.cells)).sum() == pytest.approx(2.0)


def test_points_on_a_line_and_in_one_place(tmp_path: Path) -> None:
    data = sample(SLIT, 4)
    for factor, match in ((0.0, "all 45 points lie in one place"), (1.0, "span no area")):
        line = Mesh(np.column_stack([data.mesh.points[:, 0]] * 2) * factor, data.mesh.cells)
        with pytest.raises(ConfigError, match=match):
            read_field(fluent(tmp_path, Sample(line, data.velocity, data.pressure)))


def test_a_cloud_keeps_its_gaps(tmp_path: Path) -> None:
    data = sample(SLIT, 12)
    corner = np.all(data.mesh.points > [1.0, 0.5], axis=1)
    keep = ~corner
    mesh = Mesh(data.mesh.points[keep], data.mesh.cells[:0])
    field = read_field(fluent(tmp_path, Sample(mesh, data.velocity[keep], data.pressure[keep])))
    there = field.locate(np.array([[1.5, 0.75, 0], [1.2, 0.6, 0], [0.5, 0.75, 0], [1.5, 0.25, 0]]))
    np.testing.assert_array_equal(there.found, [False, False, True, True])
    # the corner into the flow is sharp: two rings around it are near it
    near = np.linalg.norm(field.points[:, :2] - [1.0, 0.5], axis=1) < 1 / 12
    assert field.near_wall[near].all()
    far = np.linalg.norm(field.points[:, :2] - [0.5, 0.5], axis=1) < 0.2
    assert not field.near_wall[far].any()


def test_a_cloud_in_space_has_no_boundary_where_slivers_were(tmp_path: Path) -> None:
    side = np.linspace(-1.0, 1.0, 9)
    x, y, z = (axis.ravel() for axis in np.meshgrid(side + 1.0, side, side, indexing="ij"))
    u = np.column_stack([(1 - y**2) * (1 - z**2), 0 * x, 0 * x])
    cloud = Mesh(np.column_stack([x, y, z]), np.empty((0, 4), dtype=np.int64))
    field = read_field(fluent(tmp_path, Sample(cloud, u, -x)))
    assert not np.asarray(field.near_edge).any()  # a duct has no edge that points into it
    inflow = inflow_section(field)
    seeds = flux_seeds(field, inflow, 4)
    assert seeds.points[:, 0] == pytest.approx(0.0, abs=1e-9)
    # (4/3)^2 but for the recovered gradient, of third order in an eighth
    assert inflow.flux == pytest.approx(16 / 9, rel=0.01)
    paths = trace_field(field, seeds, 60)
    assert {path.end for path in paths} == {"outlet"}
    assert not any(path.near_singularity for path in paths)


def test_one_layer_of_cells_is_planar(tmp_path: Path) -> None:
    mesh = rectangle(5)
    n = len(mesh.points)
    points = np.concatenate([np.column_stack([mesh.points, np.full(n, z)]) for z in (0.0, 0.1)])
    wedges = np.column_stack([mesh.cells, mesh.cells + n])
    grid = pyvista.UnstructuredGrid({pyvista.CellType.WEDGE: wedges}, points)
    grid.point_data["U"] = SLIT.velocity(points)
    grid.save(tmp_path / "layer.vtu")
    field = read_field(tmp_path / "layer.vtu")
    assert field.geometry == "planar"
    assert "one layer of cells: read as planar" in field.notes
    assert len(field.points) == n
    assert gradient_error(field, SLIT) < ROUNDING


def test_a_wedge_is_axisymmetric(tmp_path: Path) -> None:
    mesh = rectangle(6)
    n, half = len(mesh.points), np.radians(2.5)
    x, r = mesh.points.T
    points = np.concatenate(
        [np.column_stack([x, r * np.cos(half), sign * r * np.sin(half)]) for sign in (-1, 1)]
    )
    cells = np.column_stack([mesh.cells, mesh.cells + n])
    on_axis = np.concatenate([r == 0, r == 0])
    cells = np.where(on_axis[cells], cells % n, cells)  # collapsed there, as it is in such meshes
    grid = pyvista.UnstructuredGrid({pyvista.CellType.WEDGE: cells}, points)
    u = TUBE.velocity(embedded(mesh.points))
    grid.point_data["U"] = np.concatenate([u, u])
    grid.save(tmp_path / "wedge.vtu")
    field = read_field(tmp_path / "wedge.vtu")
    assert field.geometry == "axisymmetric"
    assert any("between two planes through an axis" in note for note in field.notes)
    assert field.points[:, 1].max() == pytest.approx(1.0)
    assert len(field.points) == n
    assert gradient_error(field, TUBE) < ROUNDING


def test_planes_of_other_axes(tmp_path: Path) -> None:
    mesh = rectangle(5)
    x = embedded(mesh.points)
    points = x[:, [0, 2, 1]]  # the plane y = 0
    grid = pyvista.UnstructuredGrid({pyvista.CellType.TRIANGLE: mesh.cells}, points)
    grid.point_data["U"] = SLIT.velocity(x)[:, [0, 2, 1]]
    grid.save(tmp_path / "plane.vtu")
    field = read_field(tmp_path / "plane.vtu")
    assert "the plane's x, z are taken for x, y" in field.notes
    assert gradient_error(field, SLIT) < ROUNDING
    grid.points[:, 1] = 0.1 * grid.points[:, 0] ** 2
    grid.save(tmp_path / "plane.vtu")
    with pytest.raises(ConfigError, match="has triangles in space"):
        read_field(tmp_path / "plane.vtu")


def test_a_spreadsheet_of_several_times(tmp_path: Path) -> None:
    path = spreadsheet(tmp_path, sample(SLIT, 4))
    lines = path.read_text().splitlines()
    head = next(k for k, line in enumerate(lines) if line.startswith("% x"))
    names = ["% x", "y"]
    names += [
        f"{name} @ t={time}" for time in (0, 0.5) for name in ("u (m/s)", "v (m/s)", "p (Pa)")
    ]
    lines[head] = "".join(f"{name:<25}" for name in names)
    for k in range(head + 1, len(lines)):
        x, y, *values = lines[k].split()
        later = [str(2 * float(value)) for value in values]
        lines[k] = " ".join([x, y, *values, *later])
    path.write_text("\n".join(lines))
    assert describe_field(path).times == (0.0, 0.5)
    fast = read_field(path)
    slow = read_field(path, FieldMap(time_step=0.0))
    np.testing.assert_allclose(fast.velocity, 2 * slow.velocity)
    with pytest.raises(ConfigError, match=r"time_step = 3: .* has no such time; it has 0, 0.5"):
        read_field(path, FieldMap(time_step=3.0))


def test_a_file_with_points_that_are_no_numbers_is_described(tmp_path: Path) -> None:
    data = sample(SLIT, 4)
    points = data.mesh.points.copy()
    points[3] = np.nan
    path = fluent(tmp_path, Sample(Mesh(points, data.mesh.cells), data.velocity, data.pressure))
    assert describe_field(path).bounds == ((0.0, 2.0), (0.0, 1.0))
    assert len(read_field(path).points) == 44


def test_describing_a_file(tmp_path: Path) -> None:
    found = describe_field(spreadsheet(tmp_path, sample(SLIT, 4))).as_dict()
    assert found["format"] == "COMSOL spreadsheet"
    assert (found["dimension"], found["points"], found["cells"]) == (2, 45, 0)
    assert [array["name"] for array in found["arrays"]] == ["u", "v", "p"]
    assert [array["taken_for"] for array in found["arrays"]] == ["velocity", "velocity", "pressure"]
    assert found["arrays"][0]["range"] == [0.0, pytest.approx(1.5)]
    assert found["bounds"] == [[0.0, 2.0], [0.0, 1.0]]
    assert found["units"] == {"length": "m", "velocity": "m/s", "pressure": "Pa"}


def test_still_and_spelled_otherwise(tmp_path: Path) -> None:
    data = sample(SLIT, 4)
    with pytest.raises(ConfigError, match="is zero everywhere"):
        read_field(fluent(tmp_path, Sample(data.mesh, 0 * data.velocity, data.pressure)))
    path = starccm(tmp_path, data)
    text = path.read_text()
    head, body = text.split("\n", 1)
    rows = [f"{row},1.5,230.0" for row in body.strip().split("\n")]
    path.write_text("\n".join([head + ',"Dynamic Viscosity (Pa-s)","Temperature (C)"', *rows]))
    field = read_field(path)
    assert field.viscosity == pytest.approx(1.5)
    assert field.temperature == pytest.approx(503.15)
