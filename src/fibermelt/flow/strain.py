"""The strain at which the stress of a melt that thins is linearised, point by point.

Newton's method on the strain alone fails where a melt thins much. Here each point of integration
holds a strain ``E`` of its own, and the flow is solved with the stress ahead of it,

    S = 2 eta E + C (D - E),    C = 2 eta + 8 (d eta/ds) E E    at    s = 2 E:E;

the next ``E`` is the strain whose stress is ``S`` (for melts that yield: Rudi, Shih and Stadler
2020, doi 10.1029/2020GC009059). Where nothing deforms that strain is a smooth function of the
stress, as the stress is not of the strain. Stress is a concave function of the rate, though: where
the rate grows tenfold, an index of 0.25 has the strain of ``S`` a hundredfold, so that it is no
larger than the larger of ``D`` and ``E``. Where a melt thickens stress is the smooth function, and
``E`` is ``D``. Converged, ``E = D``, and ``S`` is the law's stress.
"""

from __future__ import annotations

import itertools
from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.melt import ViscosityLaw
from fibermelt.melt.strain import NOTHING, SPACE_WEIGHTS, WEIGHTS, strain_of_stress

__all__ = ["COMPONENTS", "HeldStrain"]

Array = NDArray[np.float64]

COMPONENTS = {
    2: ((0, 0), (1, 1), (0, 1)),
    3: ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)),
}
"""Of a symmetric tensor, by dimension, in the order that strains are kept in."""


class HeldStrain:
    """What is held at the points of integration of some elements; a Newtonian melt at first.

    ``strain``, ``viscosity`` and ``slope``, ``E``, ``eta`` and ``d eta/ds``, are expressions for
    integrals with ``rules``; ``places`` (k, dim) is where the points lie.

    Parameters
    ----------
    mesh
        The mesh, which may move.
    law : ViscosityLaw
        In scaled units.
    gradient : expression
        Velocity gradient of the present state.
    elements : BitArray
        Which ones.
    order : int
        Up to which polynomials are integrated exactly, even.
    """

    def __init__(
        self, mesh: ng.Mesh, law: ViscosityLaw, gradient: Any, elements: ng.BitArray, order: int
    ) -> None:
        """Hold no strain and a viscosity of one."""
        space = ng.comp.IntegrationRuleSpace(mesh, order=order // 2)  # its rule has twice as much
        self.rules = space.GetIntegrationRules()
        self._dim, self._components = mesh.dim, COMPONENTS[mesh.dim]
        self._weights = WEIGHTS if mesh.dim == 2 else SPACE_WEIGHTS
        rule = self.rules[ng.ET.TRIG if mesh.dim == 2 else ng.ET.TET]
        chosen = np.fromiter(elements, dtype=bool, count=mesh.ne)
        self._chosen = np.repeat(chosen, len(rule.points))
        self._points = mesh.MapToAllElements(rule, ng.VOL)[self._chosen]
        self._law, self._present = law, ng.Sym(gradient)
        held = {component: ng.GridFunction(space) for component in self._components}
        self.viscosity, self.slope = ng.GridFunction(space), ng.GridFunction(space)
        every = itertools.product(range(mesh.dim), repeat=2)
        symmetric = tuple(held[min(i, j), max(i, j)] for i, j in every)
        self.strain = ng.CF(symmetric, dims=(mesh.dim, mesh.dim))
        self._stored = [f.vec.FV().NumPy() for f in (*held.values(), self.viscosity, self.slope)]
        count = len(self._points)
        self._store(np.zeros((len(held), count)), np.ones(count), np.zeros(count))

    @property
    def places(self) -> Array:
        """Return where the points lie now."""
        return np.asarray(ng.CF((ng.x, ng.y, ng.z)[: self._dim])(self._points))

    @property
    def present(self) -> Array:
        """Return the strain of the present state, its `COMPONENTS` (3, k) or (6, k)."""
        values = np.asarray(self._present(self._points)).reshape(-1, self._dim**2)
        chosen = [self._dim * i + j for i, j in self._components]
        return np.ascontiguousarray(values[:, chosen].T)

    def hold(self, strain: Array) -> None:
        """Linearise at a strain (3, k) or (6, k)."""
        self._store(strain, *self._law.expression(2.0 * (self._weights @ strain**2) + NOTHING**2))

    def follow(self) -> None:
        """Linearise at the strain whose stress is the one ahead."""
        *held, viscosity, slope = (values[self._chosen] for values in self._stored)
        before, found = np.array(held), self.present
        ahead = self._weights @ (before * (found - before))
        stress = 2.0 * viscosity * found + 8.0 * slope * ahead * before
        strain = strain_of_stress(self._law, stress, found)
        size, *sizes = (self._weights @ values**2 for values in (strain, found, before))
        part = np.maximum(*sizes) / np.maximum(size, NOTHING**2)
        strain *= np.sqrt(np.minimum(1.0, part))
        self.hold(np.where(slope > 0.0, found, strain))

    def _store(self, strain: Array, viscosity: Array, slope: Array) -> None:
        for stored, values in zip(self._stored, (*strain, viscosity, slope), strict=True):
            stored[self._chosen] = values
