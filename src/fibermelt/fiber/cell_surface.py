"""From the finite elements' surface pressure to a smooth curve.

The surface pressure is ``P_1 = sum c_k cos 2 k s``, ``P_2 = sum d_k sin 2 k s`` by the symmetry of
fiber and cell, and its coefficients fall off like ``exp(-2 k w)`` with ``w`` the distance to the
nearest singularity (`CellGrid.tip_width`): the projection on these harmonics keeps what is
resolved and leaves out the elements' kinks. The paper's mesh is taken as it is: its pressure is
linear between the vertices on the surface, which are then the surface points.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.cell_grid import CellGrid
from fibermelt.fiber.cell_paper import PaperGrid

__all__ = [
    "lagrange_matrix",
    "project_harmonics",
    "surface_angles",
    "surface_basis",
    "surface_values",
]

Array = NDArray[np.float64]

HARMONIC_TOLERANCE = 1e-10
"""Size of the first harmonic left out, over the first one kept: far below the elements' error."""

SAMPLES_PER_HARMONIC = 8
"""Samples of the elements' pressure per harmonic kept, against aliasing of their kinks."""

POINTS_PER_HARMONIC = 6
"""Surface points of the result per harmonic: beyond the four that Nyquist asks for ``cos 2 k s``"""


def harmonics(grid: CellGrid) -> int:
    """Return the number of harmonics ``cos 2 k s`` that the surface pressure needs."""
    return max(8, math.ceil(-0.5 * math.log(HARMONIC_TOLERANCE) / grid.tip_width))


def surface_angles(grid: CellGrid, per_harmonic: int = POINTS_PER_HARMONIC) -> Array:
    """Return uniform eccentric angles in [0, 2 pi) [rad], a power of two of them."""
    count = 1 << math.ceil(math.log2(per_harmonic * harmonics(grid)))
    return 2.0 * np.pi * np.arange(count) / count


def lagrange_matrix(grid: CellGrid, order: int, angles: Array) -> tuple[NDArray[np.intp], Array]:
    """Return nodes and weights that read nodal surface values at given angles.

    Parameters
    ----------
    grid : CellGrid
        The cell's grid; its surface elements carry ``order`` equal intervals in the column
        coordinate.
    order : int
        Order of the polynomials in between.
    angles : (k,) array
        Eccentric angles in [0, 2 pi) [rad].

    Returns
    -------
    nodes : (k, order + 1) integer array
        Indices into the ``columns * order`` nodes around.
    weights : (k, order + 1) array
        Their Lagrange polynomials.
    """
    coordinate = grid.column_coordinate(angles)
    element = np.minimum(np.floor(coordinate).astype(np.intp), grid.columns - 1)
    local = (coordinate - element) * order
    steps = np.arange(order + 1)
    nodes = (element[:, None] * order + steps) % (grid.columns * order)
    weights = np.ones(nodes.shape)
    for i in range(order + 1):
        for j in range(order + 1):
            if i != j:
                weights[:, i] *= (local - j) / (i - j)
    return nodes, weights


def project_harmonics(grid: CellGrid, order: int, values: Array) -> Array:
    """Return the surface pressure basis at `surface_angles` from nodal values.

    Parameters
    ----------
    grid, order
        As in `lagrange_matrix`.
    values : (columns * order, ..., 2) array
        Nodal pressures of the two modes, last axis: even (``cos 2 k s``) and odd (``sin 2 k s``).
    """
    angles = surface_angles(grid, SAMPLES_PER_HARMONIC)
    nodes, weights = lagrange_matrix(grid, order, angles)
    samples = np.einsum("kn,kn...->k...", weights, values[nodes])
    spectrum = np.fft.rfft(samples, axis=0) / angles.size
    target = surface_angles(grid)
    kept = np.zeros((target.size // 2 + 1, *values.shape[1:]), dtype=np.complex128)
    even = np.arange(0, 2 * harmonics(grid) + 1, 2)
    kept[even, ..., 0] = spectrum[even, ..., 0].real
    kept[even, ..., 1] = 1j * spectrum[even, ..., 1].imag
    half = np.fft.irfft(kept, n=target.size, axis=0)[: target.size // 2] * target.size
    return np.concatenate([half, half])


def surface_basis(grid: CellGrid | PaperGrid, order: int, values: Array) -> tuple[Array, Array]:
    """Return the surface points' eccentric angles [rad] and the two modes' pressures there.

    Parameters
    ----------
    grid, order, values
        As in `project_harmonics`; on the paper's grid nothing is projected.

    Returns
    -------
    angles : (m,) array
    basis : (m, 2) array
    """
    if isinstance(grid, PaperGrid):
        return grid.surface_angles(), np.array(values[::order])
    return surface_angles(grid), project_harmonics(grid, order, values)


def surface_values(grid: CellGrid | PaperGrid, order: int, values: Array) -> Array:
    """Return pressures at the surface points of `surface_basis`, for any mixture of the modes.

    Parameters
    ----------
    grid, order
        As in `surface_basis`.
    values : (columns * order, k) array
        Nodal pressures of ``k`` flows.

    Returns
    -------
    (m, k) array
        The even part projected as the first mode, the odd part as the second.
    """
    if isinstance(grid, PaperGrid):
        return np.array(values[::order])
    both = project_harmonics(grid, order, np.stack([values, values], axis=-1))
    return np.asarray(both.sum(axis=-1))
