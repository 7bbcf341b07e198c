"""The strain that a melt that thins is linearised at, held at the points of integration."""

from __future__ import annotations

from typing import Any

import ngsolve as ng
import numpy as np
from numpy.typing import NDArray

from fibermelt.melt import ViscosityLaw
from fibermelt.melt.strain import NOTHING, WEIGHTS, strain_of_stress

Array = NDArray[np.float64]


class HeldStrain:
    def __init__(self, mesh: ng.Mesh, law: ViscosityLaw, gradient: Any, order: int, some: ng.BitArray) -> None:
        space = ng.comp.IntegrationRuleSpace(mesh, order=order)
        self.rules = space.GetIntegrationRules()
        self._mesh, self._law = mesh, law
        self._D = ng.Sym(gradient)
        held = [ng.GridFunction(space) for _ in range(3)]
        self.viscosity, self.slope = ng.GridFunction(space), ng.GridFunction(space)
        self.strain = ng.CF((held[0], held[2], held[2], held[1]), dims=(2, 2))
        self._stored = [f.vec.FV().NumPy() for f in (*held, self.viscosity, self.slope)]
        count = len(self.rules[ng.ET.TRIG].points)
        chosen = np.fromiter(some, dtype=bool, count=mesh.ne)
        self._chosen = np.repeat(chosen, count)
        self._points = mesh.MapToAllElements(self.rules[ng.ET.TRIG], ng.VOL)[self._chosen]
        self.E = np.zeros((3, len(self._points)))

    def places(self) -> Array:
        return np.asarray(ng.CF((ng.x, ng.y))(self._points))

    def present(self) -> Array:
        values = np.asarray(self._D(self._points)).reshape(-1, 4)
        return np.ascontiguousarray(values[:, [0, 3, 1]].T)

    def hold(self, strain: Array) -> None:
        """Linearise at a strain."""
        self.E = strain
        eta, slope = self._law.expression(2.0 * (WEIGHTS @ strain**2) + NOTHING**2)
        self._eta, self._slope = eta, slope
        for stored, values in zip(self._stored, (*strain, eta, slope), strict=True):
            stored[self._chosen] = values

    def hold_at(self, eta, E):
        self.E = E
        self._eta, self._slope = eta, 0.0 * eta
        for stored, values in zip(self._stored, (*E, eta, 0 * eta), strict=True):
            stored[self._chosen] = values

    def follow(self) -> None:
        """Hold the strain whose stress is the one ahead."""
        found = self.present()
        ahead = WEIGHTS @ (self.E * (found - self.E))
        stress = 2.0 * self._eta * found + 8.0 * self._slope * ahead * self.E
        self.hold(strain_of_stress(self._law, stress, found))
