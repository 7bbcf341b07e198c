"""Public samples of EnSight, Fluent CFF and nek5000; skipped, saying so, where they are missing."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from fibermelt.fields.mapping import FieldMap
from fibermelt.fields.reading import describe_field, read_field
from fibermelt.fields.simplices import signed_sizes

ROOT = Path(__file__).parents[2]
FOLDER = Path(os.environ.get("FIBERMELT_FIELDS", ROOT.parent / "shared" / "fields"))


def there(name: str) -> Path:
    path = FOLDER / name
    if not path.is_file():
        pytest.skip(f"no sample field {path}: FIBERMELT_FIELDS names their folder")
    return path


def test_ensight_cylinder() -> None:
    path = there("cylinder_Re35.case")
    found = describe_field(path)
    assert (found.format, found.dimension, found.cells) == ("EnSight", 2, 14594)
    assert found.taken() == {"velocity": "velocity", "pressure": "pressure"}
    field = read_field(path)
    # the crossflow past a cylinder of radius 0.5 in 15 x 7.5
    area = np.abs(signed_sizes(field.points[:, :2], field.cells)).sum()
    assert area == pytest.approx(15 * 7.5 - np.pi * 0.25, rel=1e-3)
    # its own vorticity, which it computed in its way
    spin = np.abs(field.gradient[:, 1, 0] - field.gradient[:, 0, 1])
    place = field.locate(np.array([[4.0, 0.3, 0], [6.0, -0.5, 0], [2.5, 0.0, 0]]))
    np.testing.assert_array_equal(place.found, [True, True, False])
    assert np.median(np.abs(field.divergence)) < 2e-3 * np.median(spin)


def test_fluent_room() -> None:
    for name in ("room.cas.h5", "room.dat.h5"):
        found = describe_field(there(name))
        assert found.format == "Fluent CFF"
        assert found.taken()["velocity"] == "SV_U, SV_V"
        assert found.taken()["pressure"] == "SV_P"
    field = read_field(there("room.cas.h5"))
    assert any("values of cells are taken to the nodes" in note for note in field.notes)
    # the area that VTK has of its quadrilaterals
    area = np.abs(signed_sizes(field.points[:, :2], field.cells)).sum()
    assert area == pytest.approx(8.8)


def test_nek5000_eddy() -> None:
    """Walsh's eddies: a uniform stream and an eigenfunction of Laplace's operator, periodic.

    Of such a stream function of wave number k, ``<|grad u|^2> = k^2 <|u - <u>|^2>``.
    """
    path = there("eddy_uv.nek5000")
    assert describe_field(path).times == (0.0, 0.01, 0.02)
    for time in (0.0, 0.02):
        field = read_field(path, FieldMap(time_step=time))
        assert field.points.max() == pytest.approx(2 * np.pi)
        weight = np.zeros(len(field.points))
        size = np.abs(signed_sizes(field.points[:, :2], field.cells))
        np.add.at(weight, field.cells, size[:, None] / 3)
        weight /= weight.sum()
        mean = weight @ field.velocity
        energy = weight @ ((field.velocity - mean) ** 2).sum(axis=1)
        slope = weight @ (field.gradient**2).sum(axis=(1, 2))
        assert np.sqrt(slope / energy) == pytest.approx(5.0, rel=0.02)
        assert (
            np.abs(field.divergence).max() < 0.1 * np.linalg.norm(field.gradient, axis=(1, 2)).max()
        )
