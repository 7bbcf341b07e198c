"""The mesh of a strand: conforming, of the right size, bounded by what it says."""

from __future__ import annotations

import ngsolve as ng
import numpy as np
import pytest

from fibermelt.errors import MeshError
from fibermelt.flow.problem import BeadNumerics, Nozzle
from fibermelt.flow.space.bead import bead_tube
from fibermelt.flow.space.guess import BeadGuess
from fibermelt.flow.space.tube import Tube, tube_mesh

SECTORS = 12
TUBE = Tube(np.array([-1.0, -0.4, 0.0, 0.3, 1.0]), np.array([0.0, 0.3, 0.7, 1.0]), SECTORS)
POLYGON = 0.5 * SECTORS * np.sin(np.pi / SECTORS)
"""Area of the half disc whose rim has twelve straight edges."""


def _straight(along: np.ndarray, across: np.ndarray) -> np.ndarray:
    return np.column_stack([along, across])


def test_elements_fill_the_tube_and_share_all_inner_faces() -> None:
    mesh, _ = tube_mesh(TUBE, _straight)
    assert ng.Integrate(ng.CF(1), mesh) == pytest.approx(2 * POLYGON, rel=1e-12)
    # each tetrahedron has four faces, inner ones are shared: a mesh that does not conform has more
    outer = sum(1 for _ in mesh.Elements(ng.BND))
    assert 2 * mesh.nface - outer == 4 * mesh.ne
    assert ng.Integrate(ng.CF(1), mesh, definedon=mesh.Materials("nozzle")) == pytest.approx(
        POLYGON
    )


def test_boundaries_are_where_they_say_and_look_outwards() -> None:
    mesh, _ = tube_mesh(TUBE, _straight)
    normal = ng.specialcf.normal(3)
    # over a closed surface the normal's integral vanishes; over each of these it is the area
    side = 2 * SECTORS * np.sin(np.pi / (2 * SECTORS))
    for name, area, mean in (
        ("inlet", POLYGON, (-POLYGON, 0, 0)),
        ("outlet", POLYGON, (POLYGON, 0, 0)),
        ("wall", side, (0, 0, 2)),
        ("free", side, (0, 0, 2)),
        ("symmetry", 4.0, (0, 0, -4)),
    ):
        assert ng.Integrate(ng.CF(1) * ng.ds(name), mesh) == pytest.approx(area)
        found = [ng.Integrate(normal[i] * ng.ds(name), mesh) for i in range(3)]
        np.testing.assert_allclose(found, mean, atol=1e-12)


def test_edges_on_the_rim_are_bent_to_its_circle() -> None:
    _, middles = tube_mesh(TUBE, _straight)
    sagitta = 1 - np.cos(np.pi / (2 * SECTORS))
    size = np.linalg.norm(middles, axis=1)
    bent = size > 1e-12
    np.testing.assert_allclose(size[bent], sagitta)
    layers = len(TUBE.layers)
    assert bent.sum() == SECTORS * (layers + layers - 1)  # along the rim, and the diagonals


@pytest.mark.parametrize("gap", [0.76, 0.8, 1.0, 1.2, 1.4])
@pytest.mark.parametrize("ratio", [0.8, 0.95, 1.1])
def test_no_guess_folds(gap: float, ratio: float) -> None:
    """From the gaps and speeds that are not refused, and its section is what mass balance asks."""
    nozzle = Nozzle(4.0, 1.0, 2.0, 1.0, 2.0, gap, 3.0)
    guess = BeadGuess(nozzle, ratio, 0.03)
    mesh, _ = tube_mesh(bead_tube(BeadNumerics(sectors=12), guess.stations), guess)
    area = 2 * ng.Integrate(ng.CF(1) * ng.ds("outlet"), mesh)
    assert area == pytest.approx(np.pi / 4 * ratio, rel=0.1)


def test_a_folded_guess_is_refused() -> None:
    with pytest.raises(MeshError, match=r"folds \d+ of \d+ elements: raise flow\.gap"):
        tube_mesh(TUBE, lambda along, across: np.column_stack([np.sin(3 * along), across]))
