"""The fingerprint of a file that a study names: of what is read, and of nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from fibermelt.parts.flow.field_table import ImportedField
from fibermelt.parts.flow.given import GivenFile, fingerprint
from fibermelt.parts.flow.paths_table import Paths

HEADS = {
    "flow.case": "FORMAT\ntype: ensight gold\n",
    "flow.xdmf": '<?xml version="1.0"?>\n<Xdmf Version="3.0">\n',
    "flow.nek5000": "filetemplate: flow%01d.f%05d\n",
    "flow.vtm": '<VTKFile type="vtkMultiBlockDataSet" version="1.0">\n',
    "flow.pvd": '<VTKFile type="Collection">\n',
    "flow.pvtu": "<VTKFile type='PUnstructuredGrid'>\n",
    "flow.cas.h5": "\x89HDF\r\n",
}


@pytest.mark.parametrize("name", ["flow.csv", "flow.vtu"])
def test_what_lies_beside_a_single_file_is_none_of_it(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_text('<VTKFile type="UnstructuredGrid">\n')
    before = fingerprint(str(file))
    for other in ("flow.toml", "flow.log", "flow2.csv", "flow.png"):
        (tmp_path / other).write_text("of the same name")
    assert fingerprint(str(file)) == before
    file.write_text('<VTKFile type="UnstructuredGrid" >\n')
    assert fingerprint(str(file)) != before


@pytest.mark.parametrize("name", HEADS)
def test_data_in_other_files_belong_to_a_file(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_bytes(HEADS[name].encode("latin-1"))
    found = [fingerprint(str(file))]
    (tmp_path / "flow.log").write_text("a run's words")
    assert fingerprint(str(file)) == found[0]
    (tmp_path / "flow").mkdir()
    for other in ("flow.geo", "flow0.f00001", "flow/flow_0.vtu"):
        (tmp_path / other).write_text("data")
        found.append(fingerprint(str(file)))
    assert len(set(found)) == len(found)


def test_results_in_an_openfoam_case_are_none_of_it(tmp_path: Path) -> None:
    for part in ("system/controlDict", "constant/polyMesh/points", "100/U", "flow.foam"):
        (tmp_path / part).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / part).write_text("")
    named = [str(tmp_path / name) for name in (".", "flow.foam", "system/controlDict")]
    before = [fingerprint(file) for file in named]
    (tmp_path / "results").mkdir()
    (tmp_path / "results/summary.json").write_text("{}")
    (tmp_path / "flow.toml").write_text("")
    assert [fingerprint(file) for file in named] == before
    (tmp_path / "100/U").write_text("uniform (0 0 1)")
    assert not set(map(fingerprint, named)) & set(before)


@pytest.mark.parametrize("table", [ImportedField, Paths])
def test_a_file_that_is_not_there_is_told_its_key(table: type[GivenFile]) -> None:
    told = f"{table.TABLE}.file = none.csv: cannot be read: no such file or directory; names are"
    with pytest.raises(ValueError, match=told):
        table(file="none.csv")
