"""A run for other programs: every number in a table, streamlines as VTK reads them."""

from __future__ import annotations

import base64
import csv
import io
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from stored_bead import store, stored_results

from fibermelt.engine.files import read_sealed
from fibermelt.errors import StoreError
from fibermelt.report.export import CONTENTS, LINES, export_run, streamlines_vtp, tables

KINDS = {"Float64": "<f8", "Int64": "<i8", "Int8": "<i1", "UInt8": "<u1"}


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    return stored_results(count=4)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return store(tmp_path_factory.mktemp("stored") / "out", drawn=False)


@pytest.fixture
def folder(finished: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(finished, tmp_path / "out"))


def read(results: xr.Dataset) -> dict[str, pd.DataFrame]:
    """Return every table as another program reads it."""
    return {one.name: _frame(one.csv()) for one in tables(results)}


def _frame(data: bytes) -> pd.DataFrame:
    """Return a table with every digit of its numbers, which pandas need not read."""
    head, *rows = csv.reader(io.StringIO(data.decode()))
    return pd.DataFrame([[_value(cell) for cell in row] for row in rows], columns=head)


def _value(cell: str) -> float | str:
    try:
        return float(cell or "nan")
    except ValueError:
        return cell


def test_every_variable_is_in_a_table_to_the_last_digit(results: xr.Dataset) -> None:
    found = read(results)
    alone = found.pop("numbers").set_index("name")["value"]
    for key, variable in results.variables.items():
        name = str(key)
        if not variable.dims:
            value = variable.item()
            np.testing.assert_equal(alone[name], value)
            continue
        unit = f" [{variable.attrs['units']}]" if variable.attrs["units"] != "1" else ""
        holding = [
            table
            for table in found.values()
            if any(head.split(" ")[0].startswith(name) and head.endswith(unit) for head in table)
        ]
        assert holding, name
    bounds = found["streamline-location-kind-side"]
    expected = results["extreme_bounds"].transpose("streamline", "location", "kind", "side")
    assert np.array_equal(bounds["extreme_bounds [Pa]"], expected.to_numpy().ravel())
    assert list(bounds)[:4] == ["streamline", "location", "kind", "side"]


def test_streamlines_and_angles_are_long(results: xr.Dataset) -> None:
    """Each number stands behind its labels, in whatever order the variable has its dimensions."""
    table = read(results)["streamline-initial_angle-point"]
    assert len(table) == results["lowest"].size
    row = table.iloc[-2]
    at = results["lowest"].sel(
        streamline=row["streamline"], initial_angle=row["initial_angle [rad]"]
    )
    assert row["lowest [Pa]"] == float(at.isel(point=int(row["point"])))
    turned = results.assign(lowest=results["lowest"].transpose("point", ...))
    assert read(turned)["streamline-initial_angle-point"]["lowest [Pa]"].equals(
        table["lowest [Pa]"]
    )


def test_vectors_and_tensors_stand_beside_one_another(results: xr.Dataset) -> None:
    table = read(results)["streamline-point"]
    gradient = results["gradient"].to_numpy().reshape(-1, 2, 2)
    assert np.array_equal(table["gradient_xy [1/s]"], gradient[:, 0, 1])
    assert "gradient_zz [1/s]" not in table
    assert np.array_equal(table["x [m]"], results["x"].to_numpy().ravel())


def in_space(results: xr.Dataset) -> xr.Dataset:
    """Return the results of a flow that is not planar, without what it has no stations for."""
    wide = np.zeros((results.sizes["streamline"], results.sizes["point"], 3, 3))
    wide[..., :2, :2] = results["gradient"].to_numpy()
    wide[..., 2, 0] = 7.0
    bare = results.drop_vars(["gradient", "zone_time", "zone_angle"])
    about = results["gradient"].attrs
    gradient = (("streamline", "point", "row", "column"), wide, about)
    return bare.drop_dims(["row", "column"], errors="ignore").assign(
        gradient=gradient, z=2.0 * results["x"], w=3.0 * results["u"]
    )


def test_other_variables_are_written_as_well(results: xr.Dataset) -> None:
    found = read(in_space(results))
    assert np.all(found["streamline-point"]["gradient_zx [1/s]"] == 7.0)
    assert "streamline-zone" not in found


def arrays(data: bytes) -> dict[str, tuple[np.ndarray, dict[str, str]]]:
    """Return every array of a VTK file by name, decoded from its specification."""
    found = {}
    for one in ET.fromstring(data).iter("DataArray"):
        raw = base64.b64decode(one.text or "")
        size = int(np.frombuffer(raw[:8], "<u8")[0])
        assert size == len(raw) - 8
        values = np.frombuffer(raw[8:], KINDS[one.attrib["type"]])
        width = int(one.attrib.get("NumberOfComponents", 1))
        shaped = values.reshape(-1, width) if width > 1 else values
        found[one.attrib["Name"]] = shaped, dict(one.attrib)
    return found


@pytest.mark.parametrize("spatial", [False, True])
def test_streamlines_are_lines_with_all_that_fibers_see(results: xr.Dataset, spatial: bool) -> None:
    given = in_space(results) if spatial else results
    data = streamlines_vtp(given)
    assert data is not None
    piece = ET.fromstring(data).find("PolyData/Piece")
    assert piece is not None
    lines, points = given.sizes["streamline"], given.sizes["point"]
    assert piece.attrib["NumberOfLines"] == str(lines)
    assert piece.attrib["NumberOfPoints"] == str(lines * points)
    found = arrays(data)
    place, _ = found["points"]
    z = given["z"] if spatial else xr.zeros_like(given["x"])
    expected = np.stack([one.to_numpy().ravel() for one in (given["x"], given["y"], z)], axis=-1)
    assert np.array_equal(place, expected)
    assert np.array_equal(found["connectivity"][0], np.arange(lines * points))
    assert np.array_equal(found["offsets"][0], points * np.arange(1, lines + 1))
    velocity, _ = found["velocity"]
    assert np.array_equal(velocity[:, 0], given["u"].to_numpy().ravel())
    assert bool(np.any(velocity[:, 2])) == spatial
    gradient, named = found["gradient"]
    called = [named[f"ComponentName{k}"] for k in range(9)]
    assert called == [i + j for i in "xyz" for j in "xyz"]
    size = 3 if spatial else 2
    inside = gradient.reshape(-1, 3, 3)[:, :size, :size]
    assert np.array_equal(inside, given["gradient"].to_numpy().reshape(-1, size, size))
    lowest, named = found["lowest"]
    angles = given["initial_angle"].to_numpy()
    assert lowest.shape == (lines * points, len(angles))
    second = given["lowest"].isel(initial_angle=1).transpose("streamline", "point")
    assert np.array_equal(lowest[:, 1], second.to_numpy().ravel())
    assert named["ComponentName1"] == f"{angles[1]:.6g} rad"
    assert np.array_equal(found["flux_fraction"][0], given["flux_fraction"])


def test_what_has_no_streamlines_has_no_lines(results: xr.Dataset) -> None:
    assert streamlines_vtp(results.drop_vars(["x"])) is None


def test_an_export_says_what_is_in_it_and_replaces_itself(folder: Path) -> None:
    to = folder / "export"
    first = export_run(folder, to)
    contents = read_sealed(to / CONTENTS)
    assert set(contents["files"]) == set(first["files"])
    assert {path.name for path in to.iterdir()} == {*first["files"], CONTENTS}
    assert first["bytes"] == sum((to / name).stat().st_size for name in first["files"])
    (column,) = (
        one
        for one in contents["files"]["streamline-point.csv"]["columns"]
        if one["name"] == "pressure"
    )
    assert column["unit"] == "Pa"
    assert column["meaning"]
    (to / "streamline.csv").unlink()
    assert export_run(folder, to) == first
    assert (to / "streamline.csv").is_file()
    assert not list(folder.glob(".partial-*"))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda to: (to / "mine.txt").write_text("mine"), "holds mine.txt, which no fibermelt"),
        (lambda to: (to / "numbers.csv").write_text("1"), "numbers.csv: was changed since"),
        (lambda to: (to / CONTENTS).write_text("{}"), "which no fibermelt export wrote"),
    ],
)
def test_what_is_not_its_own_is_not_overwritten(folder: Path, spoil: Any, words: str) -> None:
    to = folder / "export"
    export_run(folder, to)
    spoil(to)
    before = {path: path.read_bytes() for path in to.iterdir()}
    with pytest.raises(StoreError, match=words):
        export_run(folder, to)
    assert {path: path.read_bytes() for path in to.iterdir()} == before


def test_where_it_cannot_go(folder: Path) -> None:
    with pytest.raises(StoreError, match=r"holds config\.toml|holds figures|holds results"):
        export_run(folder, folder)
    with pytest.raises(StoreError, match="is a file, not a folder; name another with --to"):
        export_run(folder, folder / "results.nc")
    with pytest.raises(StoreError, match="there is no folder"):
        export_run(folder, folder / "none" / "export")


def test_one_that_cannot_be_written_leaves_the_old_one(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    to = folder / "export"
    export_run(folder, to)
    before = {path: path.read_bytes() for path in to.iterdir()}

    def full(path: Path, data: bytes) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("fibermelt.report.export.write_through", full)
    with pytest.raises(StoreError, match="no space left on device; free some space"):
        export_run(folder, to)
    assert {path: path.read_bytes() for path in to.iterdir()} == before
    assert not list(folder.glob(".partial-*"))


def test_lines_are_read_by_vtk(results: xr.Dataset, tmp_path: Path) -> None:
    """The library that ParaView is made of reads the file; skipped where it is not installed."""
    io_xml = pytest.importorskip("vtkmodules.vtkIOXML")
    path = tmp_path / LINES
    path.write_bytes(streamlines_vtp(results) or b"")
    reader = io_xml.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    lines = reader.GetOutput()
    assert lines.GetNumberOfLines() == results.sizes["streamline"]
    assert lines.GetPointData().GetArray("lowest").GetComponentName(0).endswith("rad")
