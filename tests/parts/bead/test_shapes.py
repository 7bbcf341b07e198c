"""Shapes of fibers: what each brings, and what stages find of it by itself."""

import numpy as np
import pytest

from fibermelt.engine.quantities import labelled
from fibermelt.errors import ConfigError
from fibermelt.fiber import CellNumerics, Ellipse, FiberModel, unbounded_ellipse
from fibermelt.melt import PowerLaw
from fibermelt.parts.bead.quantities import QUANTITIES
from fibermelt.parts.bead.shape import FiberShape, Sizes
from fibermelt.parts.bead.shapes import SHAPES, choices
from fibermelt.parts.bead.stages import stored_model

SIZES = Sizes(42e-6, 6.0)
NUMERICS = CellNumerics(order=3)


class Disc(FiberShape):
    """A shape that there is not: no more than a name, words and a model."""

    name, meaning, label, plural = "disc", "a disc", "disc", "discs"

    def model(self, sizes, cell, numerics):
        return FiberModel(self.name, unbounded_ellipse(Ellipse(sizes.half_length, 1.0)))


@pytest.fixture(params=[*SHAPES, "disc"])
def shape(request, monkeypatch):
    monkeypatch.setitem(SHAPES, "disc", Disc())
    return SHAPES[request.param]


def test_they_are_told_in_the_order_of_their_ranks():
    assert list(SHAPES) == ["confined-ellipse", "ellipse", "spheroid", "ellipsoid"]
    assert choices("in_space") == '"spheroid" or "ellipsoid"'
    assert choices("has_cell") == '"confined-ellipse"'


def test_what_is_stored_is_what_was_solved(shape):
    solved = shape.solved(SIZES, 4.0, NUMERICS, lambda line: None)
    cell = labelled({"fiber_model": shape.name, **solved}, QUANTITIES)
    found, model = stored_model(cell), shape.model(SIZES, 4.0, NUMERICS)
    assert found.name == model.name == shape.name
    assert found is stored_model(cell.copy(deep=True))
    response, same = found.response, model.response
    assert response.shape_factor == pytest.approx(same.shape_factor, abs=1e-14)
    assert response.basis == pytest.approx(same.basis, abs=1e-12 * np.abs(same.basis).max())
    assert found.has_directions == shape.in_space


def test_a_third_axis_is_stored():
    shape, thin = SHAPES["ellipsoid"], Sizes(1.0, 6.0, 12.0)
    solved = shape.solved(thin, 0.0, None, lambda line: None)
    found = stored_model(labelled({"fiber_model": "ellipsoid", **solved}, QUANTITIES))
    assert found.ellipsoid.semi_axes == pytest.approx([1.0, 1 / 6, 1 / 12])


def test_without_a_table_there_is_no_answer_in_a_melt_that_thins(shape):
    law = PowerLaw(817.0, 0.1)
    if not shape.thins or shape.name == "disc":
        with pytest.raises(ConfigError, match=f'fiber.model = "{shape.name}": has no answer'):
            shape.thinning(SIZES, law, 4.0, NUMERICS)
    elif shape.name == "spheroid":
        with pytest.raises(ConfigError, match="index"):
            shape.refuse_in_melt(SIZES, law)
    else:
        shape.refuse_in_melt(SIZES, law)
