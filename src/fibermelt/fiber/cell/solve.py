"""The two flows of a confined fiber."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import (
    ConfigError,
    ConvergenceError,
    refuse_no_number,
    refuse_other,
)
from fibermelt.fiber.cell.mesh import CurvedMesh, curved_mesh
from fibermelt.fiber.cell.stokes import Fields, Modes, sample_fields, solve_modes
from fibermelt.fiber.cell.triangles import paper_mesh
from fibermelt.fiber.cell_data import CellError, CellNumerics, CellSolution
from fibermelt.fiber.cell_grid import CellGrid
from fibermelt.fiber.cell_paper import PaperGrid
from fibermelt.fiber.cell_surface import surface_basis
from fibermelt.fiber.checks import refuse_too_slender
from fibermelt.fiber.response import FiberResponse
from fibermelt.fiber.shape import Ellipse
from fibermelt.threads import exclusive

__all__ = ["cell_grid", "drawing", "solve_cell"]

Index = NDArray[np.intp]

MOST_SLENDER = 1e3
"""Aspect ratio up to which a cell has been solved: in ten seconds, to an estimated 1.5e-5."""

LARGEST_HANDEDNESS = 1e-6
"""Largest spin at unit ``D_11`` on the graded mesh, which is its own mirror image: zero but for
rounding, up to 5e-8 at ``M = 2.0001``. It costs nothing: cells without an estimate have it, too."""


@exclusive
def solve_cell(
    fiber: Ellipse, domain_size: float, numerics: CellNumerics | None = None
) -> CellSolution:
    """Solve the cell's two flows.

    Parameters
    ----------
    fiber : Ellipse
        The fiber; its half-length only scales the answer.
    domain_size : float
        ``M``: the cell's radius is ``M a/2``, so ``M > 2`` holds the fiber. Tried from 2.0001 to
        200 with aspect ratios from 1 to 50.
    numerics : CellNumerics, optional
        Order, spacings, pressure level, error estimate.

    Returns
    -------
    CellSolution
        Shape factor, surface pressure basis, fields and error estimate.

    Raises
    ------
    ConfigError
        If the fiber does not fit into its cell, or an argument is of another type.
    ConvergenceError
        If the linear solve leaves a residual, or the flows of a symmetric mesh have a handedness.
    """
    numerics = CellNumerics() if numerics is None else numerics
    grid = cell_grid(fiber, domain_size, numerics)
    mesh = cell_mesh(grid, numerics.velocity_order)
    modes = solve_modes(mesh)
    if numerics.mesh == "graded":
        _check_symmetry(modes)
    fields = sample_fields(mesh, modes, numerics)
    response = _response(fiber, mesh, modes, fields)
    estimate = None
    if numerics.estimate:
        estimate = _compare(response, _finer(fiber, domain_size, numerics))
    cells, edges = drawing(mesh)
    return CellSolution(
        response=response,
        domain_size=domain_size,
        error_estimate=estimate,
        unknowns=modes.unknowns,
        elements=mesh.mesh.ne,
        residual=modes.residual,
        points=fields.points.reshape(-1, 2),
        cells=cells,
        element_edges=edges,
        velocity=fields.velocity.reshape(-1, 2, 2),
        pressure=fields.pressure.reshape(-1, 2),
        handedness=modes.handedness,
    )


def _check_symmetry(modes: Modes) -> None:
    """Raise if rounding, or what has no place there, broke the mirror symmetry of the flows."""
    if not abs(modes.handedness) <= LARGEST_HANDEDNESS:
        msg = (
            f"fiber cell: a fiber along the stretch spins at {modes.handedness:.1e} of it, where "
            f"symmetry has it at rest (bound {LARGEST_HANDEDNESS:g}): take a domain_size further "
            "from 2, or a lower order"
        )
        raise ConvergenceError(msg)


def cell_grid(fiber: Ellipse, domain_size: float, numerics: CellNumerics) -> CellGrid | PaperGrid:
    """Return the grid of a cell; refuse one that cannot hold or resolve it (`ConfigError`)."""
    refuse_other("fiber", fiber, Ellipse)
    refuse_other("numerics", numerics, CellNumerics)
    refuse_no_number("fiber.domain_size", domain_size)
    refuse_too_slender(fiber.aspect_ratio, MOST_SLENDER)
    if not (np.isfinite(domain_size) and domain_size > 2):
        msg = (
            f"fiber.domain_size = {domain_size:g}: the cell's radius is domain_size/2 half-lengths "
            "and must exceed one, or the fiber is larger than its cell; the paper takes 4"
        )
        raise ConfigError(msg)
    if numerics.mesh == "paper":
        return PaperGrid(1.0 / fiber.aspect_ratio, 0.5 * domain_size)
    return CellGrid(
        1.0 / fiber.aspect_ratio,
        0.5 * domain_size,
        numerics.angular_spacing,
        numerics.radial_spacing,
    )


def cell_mesh(grid: CellGrid | PaperGrid, order: int) -> CurvedMesh:
    """Return the elements of a grid; the paper's have an order of their own."""
    return paper_mesh(grid) if isinstance(grid, PaperGrid) else curved_mesh(grid, order)


def _finer(fiber: Ellipse, domain_size: float, numerics: CellNumerics) -> FiberResponse:
    """Return the response that a solution is compared with, as `CellError` says."""
    if numerics.mesh == "paper":
        order = CellNumerics().order
        grid = cell_grid(fiber, domain_size, CellNumerics())
    else:
        order = numerics.order + 1
        grid = cell_grid(fiber, domain_size, numerics)
    mesh = cell_mesh(grid, order)
    modes = solve_modes(mesh)
    return _response(fiber, mesh, modes, sample_fields(mesh, modes, numerics))


def _response(fiber: Ellipse, mesh: CurvedMesh, modes: Modes, fields: Fields) -> FiberResponse:
    """Return shape factor and surface pressure as the fiber's response."""
    angles, basis = surface_basis(mesh.grid, mesh.order, fields.pressure[:, 0, :])
    return FiberResponse(fiber.aspect_ratio, modes.shape_factor, angles, basis)


def _compare(coarse: FiberResponse, fine: FiberResponse) -> CellError:
    """Return the differences of two solutions, scaled as `CellError` says."""
    largest = fine.curve.farthest
    difference = coarse.basis - fine.curve.point(coarse.surface)
    return CellError(
        shape_factor=abs(coarse.shape_factor - fine.shape_factor),
        tip_pressure=abs(coarse.tip_pressure / fine.tip_pressure - 1.0),
        surface_pressure=float(np.max(np.abs(difference))) / largest,
    )


def drawing(mesh: CurvedMesh) -> tuple[Index, Index]:
    """Return triangles and element edges of the sampled nodes, as flat indices."""
    grid, order = mesh.grid, mesh.order
    around, outward = grid.columns * order, grid.rows * order + 1
    node = np.arange(around * outward).reshape(around, outward)
    following = np.roll(node, -1, axis=0)
    a, b = node[:, :-1].ravel(), node[:, 1:].ravel()
    c, d = following[:, 1:].ravel(), following[:, :-1].ravel()
    cells = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    steps = np.arange(order + 1)
    starts, rows = np.arange(0, around, order), np.arange(0, outward - 1, order)
    rays = node[starts][:, rows[:, None] + steps]
    rings = node[(starts[:, None] + steps) % around][:, :, ::order]
    edges = [rays.reshape(-1, order + 1), np.moveaxis(rings, 1, -1).reshape(-1, order + 1)]
    if isinstance(grid, PaperGrid):
        ahead = (starts[:, None, None] + steps) % around
        edges.append(node[ahead, rows[:, None] + steps].reshape(-1, order + 1))
    return cells, np.concatenate(edges)
