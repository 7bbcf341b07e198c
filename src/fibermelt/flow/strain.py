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

from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.melt import ViscosityLaw
from fibermelt.melt.strain import NOTHING, WEIGHTS, strain_of_stress

__all__ = ["HeldStrain"]

Array = NDArray[np.float64]


class HeldStrain:
    """What is held at the points of integration of some elements; a Newtonian melt at first.

    ``strain``, ``viscosity`` and ``slope``, ``E``, ``eta`` and ``d eta/ds``, are expressions for
    integrals with ``rules``; ``places`` (k, 2) is where the points lie.

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
        rule = self.rules[ng.ET.TRIG]
        chosen = np.fromiter(elements, dtype=bool, count=mesh.ne)
        self._chosen = np.repeat(chosen, len(rule.points))
        self._points = mesh.MapToAllElements(rule, ng.VOL)[self._chosen]
        self._law, self._present = law, ng.Sym(gradient)
        held = [ng.GridFunction(space) for _ in range(3)]
        self.viscosity, self.slope = ng.GridFunction(space), ng.GridFunction(space)
        self.strain = ng.CF((held[0], held[2], held[2], held[1]), dims=(2, 2))
        self._stored = [f.vec.FV().NumPy() for f in (*held, self.viscosity, self.slope)]
        count = len(self._points)
        self._store(np.zeros((len(WEIGHTS), count)), np.ones(count), np.zeros(count))

    @property
    def places(self) -> Array:
        """Return where the points lie now."""
        return np.asarray(ng.CF((ng.x, ng.y))(self._points))

    @property
    def present(self) -> Array:
        """Return the strain of the present state, components 11, 22, 12, (3, k)."""
        values = np.asarray(self._present(self._points)).reshape(-1, 4)
        return np.ascontiguousarray(values[:, [0, 3, 1]].T)

    def hold(self, strain: Array) -> None:
        """Linearise at a strain (3, k)."""
        self._store(strain, *self._law.expression(2.0 * (WEIGHTS @ strain**2) + NOTHING**2))

    def follow(self) -> None:
        """Linearise at the strain whose stress is the one ahead."""
        *held, viscosity, slope = (values[self._chosen] for values in self._stored)
        before, found = np.array(held), self.present
        ahead = WEIGHTS @ (before * (found - before))
        stress = 2.0 * viscosity * found + 8.0 * slope * ahead * before
        strain = strain_of_stress(self._law, stress, found)
        size, *sizes = (WEIGHTS @ values**2 for values in (strain, found, before))
        part = np.maximum(*sizes) / np.maximum(size, NOTHING**2)
        strain *= np.sqrt(np.minimum(1.0, part))
        self.hold(np.where(slope > 0.0, found, strain))

    def _store(self, strain: Array, viscosity: Array, slope: Array) -> None:
        for stored, values in zip(self._stored, (*strain, viscosity, slope), strict=True):
            stored[self._chosen] = values
