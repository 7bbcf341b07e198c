"""Read the results of a finished run, for who answers from them without computing them again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from fibermelt.errors import StoreError, legible
from fibermelt.study.files import digest, read_sealed, storage_errors
from fibermelt.study.netcdf import from_bytes
from fibermelt.study.schema import refuse_foreign

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["finished_results"]

_LONGEST_PATH = 200


def finished_results(directory: Path) -> xr.Dataset:
    """Return the results on show in a folder, checked against their digest.

    Parameters
    ----------
    directory : Path
        The results folder of a finished run.

    Raises
    ------
    StoreError
        If there is no finished run in it, it is of another schema, or its results are damaged.
    """
    shown = legible(str(directory), _LONGEST_PATH)
    path, manifest = directory / "results.nc", directory / "stages" / "outputs.json"
    with storage_errors(directory):
        if not path.is_file() or not manifest.is_file():
            msg = f"{shown}: holds no finished run; make one with fibermelt run paper --out {shown}"
            raise StoreError(msg)
        refuse_foreign(directory, directory / "stages" / "store.json")
        try:
            expected = read_sealed(manifest)["files"]["results.nc"]
            data = path.read_bytes()
        except (ValueError, KeyError, TypeError) as error:
            raise _damaged(manifest) from error
    if digest(data) != expected:
        raise _damaged(path)
    return from_bytes(data)


def _damaged(path: Path) -> StoreError:
    shown = legible(str(path), _LONGEST_PATH)
    return StoreError(
        f"{shown}: is damaged, or was changed since it was written; run the study again with "
        "--fresh to compute and write it anew"
    )
