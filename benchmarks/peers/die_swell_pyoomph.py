"""Planar Newtonian die swell in pyoomph: the peer that fibermelt's die swell is timed against.

Half channel of half-width 1 and length 4, then a free jet of length 6; creeping flow, viscosity 1,
mean velocity 1. Parabola at the inlet, no slip on the wall, symmetry on the axis, no traction and
no surface tension on the free surface, no axial traction and no cross flow at the outlet.
Taylor-Hood P2/P1 on gmsh triangles, mesh position P2; a Stokes solve on the start mesh, then
Newton on flow and mesh together. Swell is the height of the jet at the outlet.

Two formulations:

``standard``
    The package's own parts: ``PseudoElasticMesh`` and ``NavierStokesFreeSurface``.
``upwind``
    Mesh moved in y only, and the kinematic condition ``u.n = 0`` tested with
    ``q + tau u.grad_s q``, ``tau = h / (2 |u|)`` (streamline upwinding, Brooks and Hughes 1982),
    which is consistent. It removes the node-to-node oscillation that the plain Galerkin condition
    leaves on the surface.

``solve_s`` holds both solves whole: equation numbering, assembly, factorisation, substitution.
It does not hold imports, meshing, code generation or compilation. ``total_s`` adds meshing, code
generation and compilation (cached by the package after the first run), but not the imports.
"""

# pyoomph lives in its own environment, so mypy in fibermelt's sees neither it nor its classes:
# mypy: disable-error-code="import-not-found", allow-subclassing-any

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass

from pyoomph import (
    DirichletBC,
    GmshTemplate,
    MeshTemplate,
    Problem,
    WeakContribution,
)
from pyoomph.equations.ALE import PseudoElasticMesh, SingleDirectionLaplaceSmoothedMesh
from pyoomph.equations.navier_stokes import NavierStokesFreeSurface, StokesEquations
from pyoomph.expressions import dot, grad, square_root, testfunction, var

CHANNEL_LENGTH = 4.0
JET_LENGTH = 6.0
"""Ends of 5 and 8 move the swell by less than 1e-4, no more than another triangulation does."""

SPEED_FLOOR = 1e-8
"""Added to |u|^2 under the root: the lip is at rest, and tau must stay finite there."""


@dataclass(frozen=True)
class Grading:
    """Element edges: ``min(lip + growth r, surface + growth s, coarse)``.

    ``r`` is the distance to the lip, ``s`` to the free surface.
    """

    lip_edge: float
    surface_edge: float
    growth: float
    coarse_edge: float


GRADINGS = {
    "standard": Grading(lip_edge=5e-4, surface_edge=0.07, growth=0.4, coarse_edge=0.5),
    "upwind": Grading(lip_edge=5e-4, surface_edge=0.6, growth=0.4, coarse_edge=0.6),
}
"""The cheapest found that keep an error of 3e-4 when the mesh changes a little; see README.md."""


@dataclass(frozen=True)
class Result:
    """What a run gives; times in seconds, ``newton_steps`` of the coupled solve only."""

    swell: float
    unknowns: int
    solve_s: float
    total_s: float
    newton_steps: int
    elements: int
    mesh_s: float


class JetMesh(GmshTemplate):
    """Channel and jet as one rectangle, the lip at (0, 1)."""

    def __init__(self, grading: Grading) -> None:
        super().__init__()
        self.grading = grading
        self.mesh_mode = "tris"
        self.high_order_optimize = 0
        self.seconds = 0.0
        # Only the background field below decides the edges.
        self.gmsh_options["Mesh.MeshSizeExtendFromBoundary"] = 0
        self.gmsh_options["Mesh.MeshSizeFromPoints"] = 0

    def define_geometry(self) -> None:
        corners = [(-CHANNEL_LENGTH, 0), (JET_LENGTH, 0), (JET_LENGTH, 1), (0, 1)]
        corners.append((-CHANNEL_LENGTH, 1))
        points = [self.point(x, y, size=self.grading.coarse_edge) for x, y in corners]
        names = ["axis", "outlet", "free", "wall", "inlet"]
        ends = [*points[1:], points[0]]
        edges = [self.line(a, b, name=name) for a, b, name in zip(points, ends, names, strict=True)]
        self.plane_surface(*edges, name="melt")
        g = self.grading
        to_lip = "Sqrt(x*x + (y-1)*(y-1))"
        to_surface = "Sqrt(0.25*(x-Fabs(x))*(x-Fabs(x)) + (y-1)*(y-1))"
        sizes = [
            f"{g.lip_edge} + {g.growth}*{to_lip}",
            f"{g.surface_edge} + {g.growth}*{to_surface}",
            f"{g.coarse_edge}",
        ]
        fields = [self.add_mesh_size_field("MathEval", F=size) for size in sizes]
        self.set_mesh_size_background_field(self.add_mesh_size_field("Min", FieldsList=fields))

    def _do_define_geometry(self, problem: Problem, filename_trunk: str | None = None) -> None:
        # The one place that holds geometry, gmsh and reading its file back: timed, not changed.
        start = time.perf_counter()
        super()._do_define_geometry(problem, filename_trunk)
        self.seconds += time.perf_counter() - start


class DieSwell(Problem):
    """The equations and boundary conditions."""

    def __init__(self, mesh: MeshTemplate, formulation: str) -> None:
        super().__init__()
        self.template = mesh
        self.formulation = formulation
        self.newton_steps = 0
        self.ignore_command_line = True
        self.write_states = False

    def define_problem(self) -> None:
        upwind = self.formulation == "upwind"
        self.add_mesh(self.template)
        surface = NavierStokesFreeSurface(surface_tension=0)
        if upwind:
            u, n, q = var("velocity"), var("normal"), testfunction("_kin_bc")
            tau = var("element_length_h") / 2 * square_root(dot(u, u) + SPEED_FLOOR) ** (-1)
            surface += WeakContribution(-dot(u, n), tau * dot(u, grad(q)))
        motion = SingleDirectionLaplaceSmoothedMesh("y") if upwind else PseudoElasticMesh()
        inlet_speed = 1.5 * (1 - var("lagrangian_y") ** 2)
        still = {"mesh_x": True, "mesh_y": True}
        melt = StokesEquations(dynamic_viscosity=1, mode="TH") + motion
        melt += DirichletBC(velocity_x=inlet_speed, velocity_y=0, **still) @ "inlet"
        melt += DirichletBC(velocity_x=0, velocity_y=0, **still) @ "wall"
        melt += DirichletBC(velocity_y=0, mesh_y=0) @ "axis"
        melt += DirichletBC(velocity_y=0, mesh_x=True) @ "outlet"
        melt += surface @ "free"
        self.add_equations(melt @ "melt")

    def actions_after_newton_step(self) -> None:
        self.newton_steps += 1
        super().actions_after_newton_step()


def solve(grading: Grading, formulation: str) -> Result:
    """Mesh, solve the flow on the start mesh, then flow and mesh together; one thread."""
    begin = time.perf_counter()
    mesh = JetMesh(grading)
    with tempfile.TemporaryDirectory() as folder, DieSwell(mesh, formulation) as problem:
        problem.set_output_directory(folder)
        problem.set_num_threads(1)
        problem.set_linear_solver("pardiso")
        problem.initialise()
        start = time.perf_counter()
        frozen = ["melt/mesh_y", "melt/free/_kin_bc"]
        if formulation == "standard":
            frozen.append("melt/mesh_x")
        with problem.select_dofs() as dofs:
            dofs.unselect(*frozen)
            problem.solve()
        problem.newton_steps = 0
        problem.solve()
        end = time.perf_counter()
        return Result(
            swell=max(node.x(1) for node in problem.get_mesh("melt/outlet").nodes()),
            unknowns=problem.ndof(),
            solve_s=round(end - start, 4),
            total_s=round(end - begin, 4),
            newton_steps=problem.newton_steps,
            elements=problem.get_mesh("melt").nelement(),
            mesh_s=round(mesh.seconds, 4),
        )


@contextmanager
def output_to_stderr() -> Iterator[None]:
    """Send what the libraries print to standard error, also from compiled code."""
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Planar Newtonian die swell in pyoomph")
    parser.add_argument("--formulation", choices=sorted(GRADINGS), default="standard")
    for name in ("lip-edge", "surface-edge", "growth", "coarse-edge"):
        parser.add_argument(f"--{name}", type=float, help="default: of the formulation")
    parser.add_argument("--json", action="store_true", help="print the result as JSON only")
    return parser.parse_args()


def main() -> None:
    args = parse()
    # pyoomph reads sys.argv by itself and refuses what it does not know.
    sys.argv[1:] = []
    default = asdict(GRADINGS[args.formulation])
    given = {name: getattr(args, name) for name in default}
    grading = Grading(**{name: default[name] if v is None else v for name, v in given.items()})
    if not args.json:
        print(f"{args.formulation}, {grading}", flush=True)
    with output_to_stderr():
        result = solve(grading, args.formulation)
    if args.json:
        print(json.dumps(asdict(result)))
        return
    for name, value in asdict(result).items():
        print(f"{name:13s} {value}")


if __name__ == "__main__":
    main()
