"""What goes into a fiber's cell and what comes out: plain values, no finite elements loaded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fibermelt.errors import ConfigError, refuse_no_count, refuse_no_number
from fibermelt.fiber.cell_paper import PAPER_ORDER
from fibermelt.fiber.response import FiberResponse

__all__ = ["CellError", "CellNumerics", "CellSolution", "CellSystem", "FlowAround"]

Array = NDArray[np.float64]
Index = NDArray[np.intp]

ORDERS = (2, 14)
"""Velocity orders: below 2 no Taylor-Hood pair exists, above 14 rounding takes over."""

SPACINGS = (0.05, 2.0)
"""Element sizes in the stretched coordinates: from thousands of columns to barely one per tip."""

MESHES = ("graded", "paper")
"""The mesh that resolves the tips, and the paper's own."""


@dataclass(frozen=True)
class CellNumerics:
    """How a cell is solved.

    Parameters
    ----------
    order : int
        Polynomial order of velocity and geometry; the pressure's is one less (default 7).
        The graded mesh's: the paper's mesh is of order 2, whatever the default says here.
    angular_spacing, radial_spacing : float
        Largest element in the stretched coordinates of `CellGrid` [-]; smaller is finer. The graded
        mesh's, too.
    pressure_reference : {"mean", "far-node"}
        What the streamline's pressure is the pressure of: the mean over the cell's edge, or, as in
        the paper's Eq. 7, one node on it: ``(R, 0)`` in the fiber's axes, ahead of its tip.
    estimate : bool
        Whether to solve once more for an error estimate: with the order raised by one, or, for the
        paper's mesh, on the graded mesh with its defaults.
    mesh : {"graded", "paper"}
        Curved quadrilaterals that resolve the tips, or the paper's own 1800 six-node triangles
        (`fibermelt.fiber.cell_paper`), 15 percent high in the tip pressure at ``r_e = 6``.

    Raises
    ------
    ConfigError
        If a value is out of its range, or one that only the graded mesh has is set for the paper's.
    """

    order: int = 7
    angular_spacing: float = 0.6
    radial_spacing: float = 0.7
    pressure_reference: Literal["mean", "far-node"] = "mean"
    estimate: bool = True
    mesh: Literal["graded", "paper"] = "graded"

    def __post_init__(self) -> None:
        """Refuse what cannot be solved."""
        refuse_no_count("numerics.cell order", self.order)
        if not ORDERS[0] <= self.order <= ORDERS[1]:
            msg = f"numerics.cell order = {self.order}: must lie in {ORDERS[0]}..{ORDERS[1]}"
            raise ConfigError(msg)
        for name in ("angular_spacing", "radial_spacing"):
            value = getattr(self, name)
            refuse_no_number(f"numerics.cell {name}", value)
            if not SPACINGS[0] <= value <= SPACINGS[1]:
                msg = f"numerics.cell {name} = {value:g}: must lie in {SPACINGS[0]}..{SPACINGS[1]}"
                raise ConfigError(msg)
        if self.pressure_reference not in ("mean", "far-node"):
            msg = (
                f'numerics.cell pressure_reference = "{self.pressure_reference}": must be '
                '"mean" or "far-node"'
            )
            raise ConfigError(msg)
        if self.mesh not in MESHES:
            msg = f'numerics.cell mesh = "{self.mesh}": must be "graded" or "paper"'
            raise ConfigError(msg)
        if self.mesh == "paper":
            self._refuse_what_the_paper_fixes()

    def _refuse_what_the_paper_fixes(self) -> None:
        """Refuse values that would have no effect: all but the defaults, and the paper's order."""
        for field in fields(self):
            value = getattr(self, field.name)
            fixed = field.name in ("order", "angular_spacing", "radial_spacing")
            is_papers = field.name == "order" and value == PAPER_ORDER
            if fixed and value != field.default and not is_papers:
                msg = (
                    f'numerics.cell {field.name} = {value:g} has no effect with mesh = "paper", '
                    'which is of order 2 on 30 x 30 x 2 triangles: leave it out, or take "graded"'
                )
                raise ConfigError(msg)

    @property
    def velocity_order(self) -> int:
        """Return the order that is solved with: ``order``, or two on the paper's mesh."""
        return PAPER_ORDER if self.mesh == "paper" else self.order


@dataclass(frozen=True)
class CellError:
    """Difference to a better solution: what the discretisation is trusted to.

    Better is the next order on the graded mesh; for the paper's mesh, the graded one's default.

    Parameters
    ----------
    shape_factor : float
        Of ``B`` [-], absolute.
    tip_pressure : float
        Of the largest surface pressure, relative.
    surface_pressure : float
        Largest difference of ``P_1, P_2`` anywhere on the surface, over the largest pressure.
    """

    shape_factor: float
    tip_pressure: float
    surface_pressure: float


@dataclass(frozen=True, eq=False)
class CellSolution:
    """The two flows that make up everything a confined fiber will ever see.

    Mode 0 is the far field ``D_11 = 1 1/s`` (stretch along the fiber), mode 1 ``D_12 = 1 1/s``
    (tensor component) with the torque-free spin ``B`` included. Lengths are in units of the
    half-length ``a``, velocities in ``a/s``, pressures over ``mu``; axes are the fiber's.

    Parameters
    ----------
    response : FiberResponse
        Shape factor and surface pressure basis.
    domain_size : float
        ``M``: the cell's radius is ``M a/2``.
    error_estimate : CellError or None
        None if it was not asked for.
    unknowns : int
        Velocity and pressure unknowns of the solution (not of the estimate).
    elements : int
        Quadrilaterals of the graded mesh, triangles of the paper's.
    residual : float
        Algebraic residual over the size of the load [-].
    points : (N, 2) array
        Nodes for drawing.
    cells : (n_cells, 3) integer array
        Triangles between them, counter-clockwise.
    element_edges : (n_edges, k) integer array
        Nodes along each curved edge of the elements.
    velocity : (N, 2, 2) array
        Velocity at the nodes: node, mode, component.
    pressure : (N, 2) array
        Pressure at the nodes: node, mode; its level as in ``response``.
    handedness : float
        Spin at unit ``D_11`` [-] that is left out of ``response``: zero by symmetry, but not on a
        mesh that differs from its mirror image, as the paper's does.
    """

    response: FiberResponse
    domain_size: float
    error_estimate: CellError | None
    unknowns: int
    elements: int
    residual: float
    points: Array
    cells: Index
    element_edges: Index
    velocity: Array
    pressure: Array
    handedness: float = 0.0

    @property
    def shape_factor(self) -> float:
        """Return ``B`` [-]; above one the fiber stalls in simple shear."""
        return self.response.shape_factor

    @property
    def stall_angle(self) -> float | None:
        """Return the stall angle in simple shear [rad], None if the fiber tumbles."""
        return self.response.stall_angle

    @property
    def tip_pressure(self) -> float:
        """Return the largest surface pressure over an orbit in simple shear, ``/(mu gamma_dot)``.

        Over every orientation, which is an orbit if the fiber tumbles and half a turn if it stalls.
        """
        return self.response.tip_pressure


@dataclass(frozen=True, eq=False)
class FlowAround:
    """The flow around a confined fiber at one strain ``D`` of size ``d``, in its axes, to be drawn.

    Lengths are in half-lengths ``a``, velocities over ``a d``, pressures over ``eta d`` at the far
    field's rate; the far field has no spin.

    Parameters
    ----------
    points : (N, 2) array
        Nodes.
    cells : (n_cells, 3) integer array
        Triangles between them, counter-clockwise.
    element_edges : (n_edges, k) integer array
        Nodes along each curved edge of the elements.
    velocity : (N, 2) array
        Velocity there.
    pressure : (N,) array
        Pressure less the far field's.
    spin : float
        Of the fiber.
    """

    points: Array
    cells: Index
    element_edges: Index
    velocity: Array
    pressure: Array
    spin: float


@dataclass(frozen=True, eq=False)
class CellSystem:
    """The cell's matrix and its partition: what the paper's own algorithm works on (Eq. 11-14).

    Unit viscosity and half-length; unknowns are velocity coefficients and pressures over ``mu``.

    Parameters
    ----------
    matrix : (N, N) sparse array
        ``K``, symmetric, rows of all unknowns.
    free, edge, fiber : integer arrays
        Indices of the free unknowns, and of the velocities on the cell's edge and on the fiber.
    edge_modes : (n_edge, 6) array
        Coefficients on the edge of ``e_x, e_y, x e_x, y e_x, x e_y, y e_y`` (the last four are
        the gradient's components, row by row).
    fiber_modes : (n_fiber, 3) array
        Coefficients on the fiber of the rigid motions ``e_x, e_y, (-y, x)``; by virtual work their
        products with the reactions are force and torque (Eq. 18).
    surface_pressure : (m, N) sparse array
        Pressure at the surface points of ``response`` from the unknowns.
    pressure_level : (N,) array
        Functional that takes the level to subtract: the mean over the cell's edge, or the pressure
        of the far node (Eq. 7).
    solve : callable
        ``K_ff^-1`` applied to a vector, prefactored.
    response : FiberResponse
        The same cell by superposition.
    """

    matrix: Any
    free: Index
    edge: Index
    fiber: Index
    edge_modes: Array
    fiber_modes: Array
    surface_pressure: Any
    pressure_level: Array
    solve: Callable[[Array], Array]
    response: FiberResponse
