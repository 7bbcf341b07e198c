"""The bed as a film, in the plane, against the sharp contact of `solve_deposition`."""

from __future__ import annotations

from itertools import pairwise

import ngsolve as ng
import numpy as np
import pytest
from netgen.geom2d import SplineGeometry

from fibermelt.flow.deposition import solve_deposition
from fibermelt.flow.forms import BedFilm
from fibermelt.flow.freesurface import FreeSurfaceFlow
from fibermelt.flow.problem import Deposition, FlowNumerics, Nozzle
from fibermelt.flow.spaces import Boundaries
from fibermelt.flow.spacing import resample
from fibermelt.melt import Newtonian

pytestmark = pytest.mark.verification

SPEED, GAP, OUTLET = 0.9, 1.0, 3.0
"""Exit speed over the bed's, gap and outlet [widths]: a strand that is pushed on the bed."""

NOZZLE = Nozzle(1.0, 0.1, 0.1, 1.0, 0.6, GAP, OUTLET)
TOP = GAP + 0.8
LIP, EDGE = 0.004, 0.08


def _film_mesh(floor: float) -> ng.Mesh:
    """Return a strand whose whole outline is free, from both lips to the outlet."""
    turn = np.linspace(0.0, np.pi / 2, 40)
    bend = np.column_stack([0.2 - 0.7 * np.cos(turn), GAP - (GAP - floor) * np.sin(turn)])
    run = np.column_stack([np.linspace(0.25, OUTLET, 40), np.full(40, floor)])
    lower = resample(np.vstack([bend, run]), EDGE, 0.3, LIP, None)
    x = np.linspace(0.5, OUTLET, 80)
    fall = SPEED + (GAP - SPEED) * np.exp(-4.0 * (x - 0.5))
    upper = resample(np.column_stack([x, fall]), EDGE, 0.3, LIP, None)

    geometry = SplineGeometry()

    def line(points: list[int], name: str, left: int, right: int = 0) -> None:
        for ends in pairwise(points):
            geometry.Append(["line", *ends], leftdomain=left, rightdomain=right, bc=name)

    def placed(curve: np.ndarray) -> list[int]:
        return [int(geometry.AppendPoint(float(x), float(y))) for x, y in curve]

    below, above = placed(lower), placed(upper)
    inlet = placed(np.array([[-0.5, TOP], [0.5, TOP]]))
    line(below, "free", 1)
    line(above[::-1], "free", 1)
    line([below[-1], above[-1]], "outlet", 1)
    line([above[0], below[0]], "exit", 1, 2)
    line([inlet[0], below[0]], "wall", 2)
    line([above[0], inlet[1]], "wall", 2)
    line(inlet[::-1], "inlet", 2)
    geometry.SetMaterial(1, "bead")
    geometry.SetMaterial(2, "nozzle")
    return ng.Mesh(geometry.GenerateMesh(maxh=0.15, grading=0.3))


def test_a_film_is_a_sharp_bed_to_first_order() -> None:
    thickness = ng.Parameter(0.04)
    boundaries = Boundaries(
        moving="bead",
        free="free",
        velocity={
            "inlet": (0, -1.5 * SPEED * (1 - 4 * ng.x**2)),
            "wall": (0, 0),
            "outlet": (1, 0),
        },
        held=("outlet|exit|wall|inlet", "exit|wall|inlet"),
        symmetry=("", ""),
        film=BedFilm(thickness),
    )
    flow = FreeSurfaceFlow(_film_mesh(0.02), boundaries, 2)
    seen = []
    for film in (0.04, 0.02, 0.01):
        thickness.Set(film)
        for _ in range(12):
            step = flow.step()
            if step.fraction == 1.0 and step.size < 1e-6:
                break
        assert step.size < 1e-6
        x, y = flow.places("free").T
        pressure = ng.Integrate(flow.pressure * ng.ds("inlet"), flow.mesh)
        touches = y < 2 * film
        seen.append((x.min(), pressure, y[x > OUTLET - 1e-9].max(), x[touches].min()))
    thick, middle, thin = np.array(seen)
    sharp = solve_deposition(
        Deposition(NOZZLE, Newtonian(1.0), inlet_speed=SPEED, bed_speed=1.0),
        FlowNumerics().coarsened(4.0),
    )
    assert np.all(np.abs(thin - middle)[:3] < 0.65 * np.abs(middle - thick)[:3])  # first order
    heel, pressure, height, _ = 2 * thin - middle
    # the lip's edge and what the extrapolation leaves: 4e-4, 3e-3, 5e-4 were seen
    assert heel == pytest.approx(sharp.heel, abs=2e-3)
    assert pressure == pytest.approx(sharp.inlet_pressure, rel=5e-3)
    assert height == pytest.approx(SPEED, abs=1e-3)
    # a contact without a film, at y = 2 films with it
    assert thin[3] == pytest.approx(sharp.contact_point, abs=6e-3)
