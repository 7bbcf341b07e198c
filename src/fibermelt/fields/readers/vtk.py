"""What VTK reads, through pyvista: VTK's own files, EnSight, CGNS, Fluent's CFF, OpenFOAM and more.

pyvista is an optional extra: ``pip install "fibermelt[fields]"``. Cells of any kind are split into
simplices (of higher order: triangles of any order, quadrilaterals, tetrahedra and hexahedra of the
second; of the others the corners are read, and that is told); values of cells are taken to their
nodes; blocks are put together.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from fibermelt.errors import ConfigError, legible, legible_path
from fibermelt.fields.averaging import cells_to_nodes
from fibermelt.fields.contents import Contents, Reader
from fibermelt.fields.readers.openfoam import case_folder, with_case
from fibermelt.fields.readers.times import chosen_time
from fibermelt.fields.splitting import CORNERS, split_cells, split_polyhedra

__all__ = ["INSTALL", "READERS"]

Array = NDArray[np.float64]
Index = NDArray[np.int64]

INSTALL = 'pip install "fibermelt[fields]"'

HDF5 = b"\x89HDF\r\n\x1a\n"

SOLID = frozenset({10, 11, 12, 13, 14, 24, 25, 26, 27, 29, 31, 32, 33, 37, 42, 71, 72, 73, 74})
FLAT = frozenset({5, 7, 8, 9, 22, 23, 28, 69, 70})
"""VTK's types of cells with a volume, and with an area."""

POLYHEDRON = 42

XML_KINDS = {
    "UnstructuredGrid": ".vtu",
    "PUnstructuredGrid": ".pvtu",
    "PolyData": ".vtp",
    "ImageData": ".vti",
    "StructuredGrid": ".vts",
    "RectilinearGrid": ".vtr",
    "vtkMultiBlockDataSet": ".vtm",
    "Collection": ".pvd",
}

HEAD = 1024
"""Bytes of an XML file that its kind stands in."""

LARGEST = 1e15
"""Coordinates beyond it, or all below its inverse, are no lengths: bytes in another order."""


def _xml_kind(head: bytes) -> str:
    match = re.search(rb"<VTKFile[^>]*?\btype\s*=\s*[\"'](\w+)[\"']", head)
    return XML_KINDS.get(match.group(1).decode(), "") if match else ""


def _hdf5_keys(path: Path, head: bytes) -> set[str]:
    """Return the names on the top level of an HDF5 file, none if it is no such file.

    Raises
    ------
    ConfigError
        If it is one, but damaged.
    """
    if not head.startswith(HDF5):
        return set()
    import h5py  # noqa: PLC0415  lazy: most formats need it not

    try:
        with h5py.File(path) as file:
            return set(file)
    except OSError as error:
        raise _damaged(path, "HDF5", str(error)) from error


def _pyvista(path: Path, kind: str) -> Any:
    try:
        import pyvista  # noqa: PLC0415  lazy: an optional extra
    except ImportError as error:
        msg = f"field.file = {legible_path(path)}: {kind} is read by pyvista, which is not here: "
        raise ConfigError(msg + INSTALL) from error
    return pyvista


def _damaged(path: Path, kind: str, reason: str) -> ConfigError:
    # where in VTK's sources, and the address of an object, help nobody
    plain = re.sub(r"(?:ERROR: )?In \S+, line \d+|\w+ \(0x[0-9a-f]+\):", "", reason)
    line = legible(" ".join(plain.split()), 160)
    msg = (
        f"field.file = {legible_path(path)}: cannot be read as {kind}: truncated, damaged, or "
        f"written in another byte order; export it again" + (f" ({line})" if line else "")
    )
    return ConfigError(msg)


def _by_suffix(
    pyvista: Any, source: Path, suffix: str, path: Path, time_step: float | None
) -> tuple[Any, tuple[float, ...]]:
    """Return what pyvista's reader for a suffix makes of a file, and all times there are."""
    reader = pyvista.get_reader(str(source), force_ext=suffix)
    times = tuple(getattr(reader, "time_values", None) or ())
    if times:
        reader.set_active_time_value(chosen_time(path, times, time_step))
    if suffix == ".foam":
        # VTK's way from cells to points is a mean, which is no plane
        reader.cell_to_point_creation = False
        reader.enable_all_patch_arrays()
    return reader.read(), times


def _xdmf(
    pyvista: Any, source: Path, suffix: str, path: Path, time_step: float | None
) -> tuple[Any, tuple[float, ...]]:
    """Return the same of XDMF, which pyvista's reader refuses without times."""
    from vtkmodules.vtkCommonExecutionModel import (  # noqa: PLC0415  with pyvista
        vtkStreamingDemandDrivenPipeline,
    )
    from vtkmodules.vtkIOXdmf2 import vtkXdmfReader  # noqa: PLC0415  with pyvista

    reader = vtkXdmfReader()
    reader.SetFileName(str(source))
    reader.UpdateInformation()
    found = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    times = tuple(found or ())
    if times:
        reader.UpdateTimeStep(chosen_time(path, times, time_step))
    reader.Update()
    return pyvista.wrap(reader.GetOutputDataObject(0)), times


@contextmanager
def _silent() -> Iterator[None]:
    """Keep from the terminal what VTK's readers print there, under Python's feet."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = {stream: os.dup(stream) for stream in (1, 2)}
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for stream in kept:
            os.dup2(nowhere, stream)
        yield
    finally:
        for stream, copy in kept.items():
            os.dup2(copy, stream)
            os.close(copy)
        os.close(nowhere)


def _read(kind: str, suffix: str, path: Path, time_step: float | None) -> Contents:
    """Return what is in a file by the reader that pyvista has for a suffix."""
    pyvista = _pyvista(path, kind)
    from vtkmodules.vtkCommonCore import vtkLogger  # noqa: PLC0415  with pyvista

    source = path
    if suffix == ".foam":
        source = (case_folder(path) or path) / "system" / "controlDict"
    if suffix == ".h5":
        source = Path(re.sub(r"\.dat(\.h5)?$", r".cas\1", str(path)))
    with tempfile.TemporaryDirectory() as scratch:
        if suffix == ".nek5000":
            source = _nek5000(path, Path(scratch))
        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
        catcher = pyvista.VtkErrorCatcher(send_to_logging=False)
        try:
            with _silent(), catcher:
                read = _xdmf if suffix == ".xdmf" else _by_suffix
                data, times = read(pyvista, source, suffix, path, time_step)
        except ConfigError:
            raise
        except Exception as error:  # VTK's readers raise what they like
            raise _damaged(path, kind, str(error)) from error
        finally:
            vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_INFO)
    faults = [str(event.alert or "") for event in catcher.error_events]
    # VTK cannot read back the range that it wrote of an array with NaN; the array it can
    faults = [fault for fault in faults if "InformationKey" not in fault]
    if faults:
        raise _damaged(path, kind, faults[0])
    contents = _contents(path, kind, data, times)
    return _with_case(path, contents, data, time_step) if suffix == ".foam" else contents


def _nek5000(path: Path, scratch: Path) -> Path:
    """Return a description of those of a run's files that are there, which may be fewer."""
    text = path.read_text(encoding="latin-1")
    keys = dict(re.findall(r"(?m)^\s*(\w+)\s*:\s*(\S+)", text))
    template, first = keys.get("filetemplate", ""), int(keys.get("firsttimestep", "0"))
    count = int(keys.get("numtimesteps", "1"))

    def file_of(number: int) -> Path:
        values = (0, number)[-template.count("%") :]
        return path.parent / str(template % values)

    try:
        there = [file_of(number).is_file() for number in range(first, first + count)]
    except (TypeError, ValueError) as error:
        raise _damaged(path, "nek5000", f"filetemplate: {template}") from error
    count = there.index(False) if False in there else count
    if count == 0:
        msg = f"field.file = {legible_path(path)}: there is no file {legible_path(file_of(first))}"
        raise ConfigError(msg)
    found = scratch / "run.nek5000"
    found.write_text(
        f"filetemplate: {path.parent.absolute()}/{template}\n"
        f"firsttimestep: {first}\nnumtimesteps: {count}\n",
        encoding="utf-8",
    )
    return found


def _with_case(path: Path, contents: Contents, data: Any, time_step: float | None) -> Contents:
    """Return OpenFOAM's contents with what its patches give."""
    patches = {}
    boundary = data["boundary"] if "boundary" in data.keys() else {}  # noqa: SIM118  no dict
    for name in boundary.keys():  # noqa: SIM118
        for grid in _leaves(boundary[name]):
            piece = _piece(path, grid, FLAT)
            patches[name] = (piece.points, piece.arrays)
    time = chosen_time(path, contents.times, time_step) if contents.times else 0.0
    return with_case(case_folder(path) or path, time, contents, patches)


def _leaves(data: Any) -> Iterator[Any]:
    """Yield the grids in what a reader returns, blocks in blocks as well."""
    if hasattr(data, "keys") and hasattr(data, "n_blocks"):
        for number in range(data.n_blocks):
            if data[number] is not None:
                yield from _leaves(data[number])
    elif data is not None and hasattr(data, "n_cells") and data.n_cells:
        grid = data.cast_to_unstructured_grid()
        if grid.n_cells:
            yield grid


def _contents(path: Path, kind: str, data: Any, times: tuple[float, ...]) -> Contents:
    grids = list(_leaves(data))
    types = [frozenset(np.unique(grid.celltypes).tolist()) for grid in grids]
    is_solid = any(found & SOLID for found in types)
    wanted = SOLID if is_solid else FLAT
    kept = [grid for grid, found in zip(grids, types, strict=True) if found & wanted]
    if not kept:
        msg = f"field.file = {legible_path(path)}: has no cells with an area or a volume" + (
            ": a truncated file, or one of points and lines" if grids else ": truncated?"
        )
        raise ConfigError(msg)
    pieces = [_piece(path, grid, wanted) for grid in kept]
    names = [name for name in pieces[0].arrays if all(name in p.arrays for p in pieces)]
    notes = list(dict.fromkeys(note for piece in pieces for note in piece.notes))
    offsets = np.cumsum([0] + [len(piece.points) for piece in pieces])
    cells = [
        piece.cells + offset
        for piece, offset in zip(pieces, offsets, strict=False)
        if piece.cells is not None
    ]
    return Contents(
        format=kind,
        points=np.concatenate([piece.points for piece in pieces]),
        arrays={name: np.concatenate([piece.arrays[name] for piece in pieces]) for name in names},
        cells=np.concatenate(cells),
        file_cells=sum(piece.file_cells for piece in pieces),
        times=times,
        notes=tuple(notes),
        from_cells=frozenset(name for piece in pieces for name in piece.from_cells),
    )


def _piece(path: Path, grid: Any, wanted: frozenset[int]) -> Contents:
    """Return one grid's cells of the kinds wanted as simplices, with values at its nodes."""
    points = np.asarray(grid.points, dtype=np.float64)
    size = float(np.abs(points).max(initial=0.0))
    if not np.isfinite(points).all() or size > LARGEST or 0 < size < 1.0 / LARGEST:
        raise _damaged(path, "a grid", f"coordinates up to {size:.3g}")
    types = np.asarray(grid.celltypes)
    connectivity = np.asarray(grid.cell_connectivity, dtype=np.int64)
    # older pyvista has the second name only, newer ones warn of it
    starts = grid.cell_offsets if hasattr(grid, "cell_offsets") else grid.offset
    offset = np.asarray(starts, dtype=np.int64)
    chosen = np.isin(types, list(wanted))
    if "vtkGhostType" in grid.cell_data:
        chosen &= np.asarray(grid.cell_data["vtkGhostType"]) == 0
    if connectivity.size and (connectivity.min() < 0 or connectivity.max() >= len(points)):
        raise _damaged(path, "a grid", f"a cell names point {int(connectivity.max())}")
    simplices, notes = _simplices(grid, types, connectivity, offset, chosen)
    arrays = _arrays(grid.point_data, len(points))
    at_cells = _arrays(grid.cell_data, len(types))
    at_cells = {name: values for name, values in at_cells.items() if name not in arrays}
    rows = np.flatnonzero(chosen)
    if at_cells and rows.size:
        arrays |= _to_nodes(points, connectivity, offset, rows, at_cells)
        notes.append("values of cells are taken to the nodes, by quadratics through those around")
    empty = np.empty((0, 4 if wanted is SOLID else 3), dtype=np.int64)
    return Contents(
        format="",
        points=points,
        arrays=arrays,
        cells=np.concatenate([empty, *simplices]),
        file_cells=int(chosen.sum()),
        notes=tuple(notes),
        from_cells=frozenset(at_cells),
    )


def _simplices(
    grid: Any, types: Index, connectivity: Index, offset: Index, chosen: NDArray[np.bool_]
) -> tuple[list[Index], list[str]]:
    """Return the simplices of a grid's chosen cells, by kind, and what is not whole, in words."""
    sizes = np.diff(offset)
    simplices, notes = [], []
    for kind in np.unique(types[chosen]):
        if kind == POLYHEDRON:
            simplices.append(_polyhedra(grid, np.flatnonzero(chosen & (types == kind))))
            continue
        for count in np.unique(sizes[chosen & (types == kind)]):
            rows = np.flatnonzero(chosen & (types == kind) & (sizes == count))
            nodes = connectivity[offset[rows][:, None] + np.arange(count)]
            found = split_cells(int(kind), nodes)
            if found is None:
                notes.append(f"{len(rows)} cells of VTK's type {kind} are left out")
                continue
            if len(np.unique(found)) < len(np.unique(nodes)) and int(kind) in CORNERS:
                notes.append("of cells of higher order the corners are read")
            simplices.append(found)
    return simplices, notes


def _arrays(data: Any, count: int) -> dict[str, Array]:
    """Return the arrays of real numbers among some of VTK's."""
    found = {}
    for name in data.keys():  # noqa: SIM118  pyvista's is no dict
        values = np.asarray(data[name])
        if values.dtype.kind == "f" and len(values) == count and values.ndim <= 2:
            found[name] = values
    return found


def _polyhedra(grid: Any, rows: Index) -> Index:
    """Return the tetrahedra of a grid's polyhedra."""
    from vtkmodules.util.numpy_support import vtk_to_numpy  # noqa: PLC0415  with pyvista

    faces, located = grid.GetPolyhedronFaces(), grid.GetPolyhedronFaceLocations()
    nodes = vtk_to_numpy(faces.GetConnectivityArray()).astype(np.int64)
    ends = vtk_to_numpy(faces.GetOffsetsArray()).astype(np.int64)
    face = vtk_to_numpy(located.GetConnectivityArray()).astype(np.int64)
    of_cell = vtk_to_numpy(located.GetOffsetsArray()).astype(np.int64)
    owner = np.full(len(ends) - 1, -1, dtype=np.int64)
    owner[face] = np.repeat(np.arange(len(of_cell) - 1), np.diff(of_cell))
    kept = np.flatnonzero(np.isin(owner, rows))
    sizes = np.diff(ends)[kept]
    taken = np.concatenate([nodes[ends[k] : ends[k + 1]] for k in kept])
    return split_polyhedra(taken, np.concatenate([[0], np.cumsum(sizes)]), owner[kept])


def _to_nodes(
    points: Array, connectivity: Index, offset: Index, rows: Index, at_cells: Mapping[str, Array]
) -> dict[str, Array]:
    """Return the values of some cells at the nodes; NaN at those of cells without a number."""
    sizes = np.diff(offset)[rows]
    node = np.concatenate([connectivity[offset[row] : offset[row + 1]] for row in rows])
    cell = np.repeat(np.arange(len(rows)), sizes)
    centres = np.zeros((len(rows), 3))
    np.add.at(centres, cell, points[node])
    centres /= sizes[:, None]
    alike: dict[bytes, list[str]] = {}
    for name, values in at_cells.items():
        known = np.isfinite(values[rows]).reshape(len(rows), -1).all(axis=1)
        alike.setdefault(known.tobytes(), []).append(name)
    found: dict[str, Array] = {}
    for mask, names in alike.items():
        known = np.frombuffer(mask, dtype=bool)
        beside = np.zeros(len(points), dtype=bool)
        beside[node[~known[cell]]] = True
        own = known[cell]
        used, number = np.unique(node[own], return_inverse=True)
        place = np.cumsum(known) - 1
        member = csr_array(
            (np.ones(int(own.sum()), dtype=bool), (number.reshape(-1), place[cell[own]])),
            (len(used), int(known.sum())),
        )
        values = np.column_stack([at_cells[name][rows[known]] for name in names]).astype(np.float64)
        spread = np.full((len(points), values.shape[1]), np.nan)
        if used.size:
            spread[used] = cells_to_nodes(points[used], centres[known], member, values)
        spread[beside] = np.nan
        widths = [1 if at_cells[name].ndim == 1 else at_cells[name].shape[1] for name in names]
        parts = np.split(spread, np.cumsum(widths)[:-1], axis=1)
        found |= {
            name: part[:, 0] if at_cells[name].ndim == 1 else part
            for name, part in zip(names, parts, strict=True)
        }
    return found


def _read_xml(path: Path, time_step: float | None) -> Contents:
    with path.open("rb") as file:
        return _read("VTK XML", _xml_kind(file.read(HEAD)), path, time_step)


def _is_exodus(path: Path, head: bytes) -> bool:
    keys = _hdf5_keys(path, head)
    return head[:4] in {b"CDF\x01", b"CDF\x02", b"CDF\x05"} or bool(
        {"coordx", "coord", "eb_prop1"} & keys
    )


READERS: tuple[Reader, ...] = (
    Reader("VTK XML", lambda _, head: bool(_xml_kind(head)), _read_xml),
    Reader(
        "VTK legacy",
        lambda _, head: head.startswith(b"# vtk DataFile"),
        partial(_read, "VTK legacy", ".vtk"),
    ),
    Reader(
        "VTK HDF",
        lambda path, head: "VTKHDF" in _hdf5_keys(path, head),
        partial(_read, "VTK HDF", ".vtkhdf"),
    ),
    Reader(
        "EnSight",
        lambda _, head: re.search(rb"(?mi)^\s*type:\s*ensight", head) is not None,
        partial(_read, "EnSight", ".case"),
    ),
    Reader("XDMF", lambda _, head: b"<Xdmf" in head, partial(_read, "XDMF", ".xdmf")),
    Reader(
        "nek5000",
        lambda _, head: re.search(rb"(?m)^\s*filetemplate\s*:", head) is not None,
        partial(_read, "nek5000", ".nek5000"),
    ),
    Reader(
        "Fluent CFF",
        lambda path, head: bool({"meshes", "results"} & _hdf5_keys(path, head)),
        partial(_read, "Fluent CFF", ".h5"),
    ),
    Reader(
        "CGNS",
        lambda path, head: (
            b"ADF Database Version" in head[:64]
            or any(key.startswith("CGNSLibraryVersion") for key in _hdf5_keys(path, head))
        ),
        partial(_read, "CGNS", ".cgns"),
    ),
    Reader("Exodus", _is_exodus, partial(_read, "Exodus", ".e")),
    Reader(
        "OpenFOAM",
        lambda path, _: case_folder(path) is not None,
        partial(_read, "OpenFOAM", ".foam"),
    ),
)
