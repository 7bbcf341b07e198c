"""Labelled arrays to netCDF bytes and back; no variable without a unit and a long name.

What values stand for (none, yes or no, coordinates) is encoded by xarray; the file is laid out here
as netCDF-4 lies in HDF5 (Unidata, *NetCDF-4/HDF5 File Format*), and any reader of netCDF reads it.
The library that xarray has for this finds every dimension anew for each variable: ten times slower.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from fibermelt.errors import StoreError

if TYPE_CHECKING:
    import h5py
    import xarray as xr

__all__ = ["from_bytes", "to_bytes"]

BARE = "This is a netCDF dimension but not a netCDF variable."
"""How the label of a dimension without a variable begins; its size follows, ten letters wide."""

OF_THE_FILE = frozenset(
    {"CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST"}
    | {"_Netcdf4Dimid", "_Netcdf4Coordinates", "_NCProperties"}
)
"""Attributes that lay out the file, and say nothing of a variable or a dataset."""


def to_bytes(dataset: xr.Dataset) -> bytes:
    """Return a dataset as a netCDF-4 file in memory.

    In memory, so that a full disk is met by one plain write, not inside the HDF5 library.

    Raises
    ------
    StoreError
        If a variable has no ``units`` or no ``long_name``.
    """
    import h5py  # noqa: PLC0415  lazy: a run that finds everything done never needs it
    from xarray import conventions  # noqa: PLC0415

    for name, variable in dataset.variables.items():
        missing = [
            attribute for attribute in ("units", "long_name") if attribute not in variable.attrs
        ]
        if missing:
            msg = f"results: variable {name} has no {' and no '.join(missing)}: give it both"
            raise StoreError(msg)
    variables, attributes = conventions.cf_encoder(*conventions.encode_dataset_coordinates(dataset))
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", track_order=True) as file:
        file.attrs["_NCProperties"] = np.bytes_(f"version=2,h5py={h5py.version.version}")
        _describe(file, attributes)
        scales = {}
        for number, (dimension, size) in enumerate(dataset.sizes.items()):
            if dimension in variables:
                scale, label = _write(file, str(dimension), variables[dimension]), dimension
            else:
                scale, label = file.create_dataset(dimension, (size,), ">f4"), f"{BARE}{size:10d}"
            scale.make_scale(label)
            scale.attrs["_Netcdf4Dimid"] = np.int32(number)
            scales[dimension] = scale
        numbers = {dimension: number for number, dimension in enumerate(scales)}
        for name, variable in variables.items():
            written = scales[name] if name in scales else _write(file, str(name), variable)
            if variable.dims:
                on = [numbers[dimension] for dimension in variable.dims]
                written.attrs["_Netcdf4Coordinates"] = np.array(on, np.int32)
            if name not in scales:
                for axis, dimension in enumerate(variable.dims):
                    written.dims[axis].attach_scale(scales[dimension])
    return buffer.getvalue()


def _write(file: h5py.File, name: str, variable: xr.Variable) -> h5py.Dataset:
    """Write a variable's values and attributes."""
    import h5py  # noqa: PLC0415  lazy, as above

    values, kind = variable.to_numpy(), variable.dtype
    if kind.kind in "OU":
        values, kind = values.astype(object), h5py.string_dtype()
    fill = variable.attrs.get("_FillValue")
    written = file.create_dataset(
        name, values.shape, kind, values, fillvalue=fill, track_order=True
    )
    _describe(written, variable.attrs)
    return written


def _describe(written: h5py.File | h5py.Dataset, attributes: dict[str, Any]) -> None:
    """Write attributes: a text as it is, a number as an array of one, as netCDF has them."""
    for name, value in attributes.items():
        written.attrs[name] = value if isinstance(value, str) else np.atleast_1d(value)


def from_bytes(data: bytes) -> xr.Dataset:
    """Return the dataset of a netCDF-4 file in memory, as `to_bytes` wrote it, loaded."""
    import h5py  # noqa: PLC0415  lazy, as above
    import xarray as xr  # noqa: PLC0415

    with h5py.File(io.BytesIO(data), "r") as file:
        described = {name: (written, dict(written.attrs)) for name, written in file.items()}
        dimensions = {
            int(attributes["_Netcdf4Dimid"]): name
            for name, (_, attributes) in described.items()
            if "_Netcdf4Dimid" in attributes and "CLASS" in attributes
        }
        variables = {
            name: (
                [dimensions[int(number)] for number in attributes.get("_Netcdf4Coordinates", ())],
                _values(written),
                _told(attributes),
            )
            for name, (written, attributes) in described.items()
            if not attributes.get("NAME", b"").startswith(BARE.encode())
        }
        raw = xr.Dataset(variables, attrs=_told(file.attrs))
    return xr.decode_cf(raw).load()


def _values(written: h5py.Dataset) -> Any:
    """Return the values of a variable, texts as an array of texts."""
    if written.dtype.kind != "O":
        return written[()]
    return np.asarray(written.asstr()[()], dtype=object).astype(str)


def _told(attributes: h5py.AttributeManager | dict[str, Any]) -> dict[str, Any]:
    """Return the attributes that say something, an array of one number as that number."""
    found = {name: value for name, value in attributes.items() if name not in OF_THE_FILE}
    return {
        name: value[0] if isinstance(value, np.ndarray) and value.size == 1 else value
        for name, value in found.items()
    }
