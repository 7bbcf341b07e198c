"""Labelled arrays to netCDF bytes and back; no variable without a unit and a long name."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from fibermelt.errors import StoreError

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["from_bytes", "to_bytes"]


def to_bytes(dataset: xr.Dataset) -> bytes:
    """Return a dataset as a netCDF-4 file in memory.

    In memory, so that a full disk is met by one plain write, not inside the HDF5 library.

    Raises
    ------
    StoreError
        If a variable has no ``units`` or no ``long_name``.
    """
    for name, variable in dataset.variables.items():
        missing = [
            attribute for attribute in ("units", "long_name") if attribute not in variable.attrs
        ]
        if missing:
            msg = f"results: variable {name} has no {' and no '.join(missing)}: give it both"
            raise StoreError(msg)
    buffer = io.BytesIO()
    dataset.to_netcdf(buffer, engine="h5netcdf")
    return buffer.getvalue()


def from_bytes(data: bytes) -> xr.Dataset:
    """Return the dataset of a netCDF-4 file in memory, loaded."""
    import xarray as xr  # noqa: PLC0415  lazy: a run that finds everything done never needs it

    with xr.open_dataset(io.BytesIO(data), engine="h5netcdf") as dataset:
        return dataset.load()
