"""From a melt's stress to its strain, for arrays of both."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fibermelt.melt.law import ViscosityLaw

__all__ = ["NOTHING", "SPACE_WEIGHTS", "WEIGHTS", "strain_of_stress"]

Array = NDArray[np.float64]

MOST_INVERSIONS = 60
"""Newton steps for the strain of a stress, in the logarithm; 3 to 6 are taken."""

INVERSION_TOLERANCE = 1e-10
"""Relative error of a rate at its stress, far below the residual's of any flow."""

NOTHING = 1e-14
"""Rate of deformation in units of the flow's that stands for none: its logarithm is taken."""

WEIGHTS = np.array([1.0, 1.0, 2.0])
"""Of the components 11, 22, 12 in a product of two symmetric tensors."""

SPACE_WEIGHTS = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
"""The same in space, of 11, 22, 33, 12, 13, 23."""


def strain_of_stress(law: ViscosityLaw, stress: Array, strain: Array) -> Array:
    """Return the strain ``E`` [1/s] whose stress ``2 eta(gamma_dot) E`` [Pa] is given.

    Parameters
    ----------
    law : ViscosityLaw
        Its stress must grow with its rate.
    stress : (3, k) or (6, k) array
        Components 11, 22, 12, or in space 11, 22, 33, 12, 13, 23.
    strain : (3, k) or (6, k) array
        A guess of its size.
    """
    weights = WEIGHTS if len(stress) == len(WEIGHTS) else SPACE_WEIGHTS
    size = np.sqrt(0.5 * (weights @ stress**2))
    wanted, rate = np.log(size + NOTHING), np.log(np.sqrt(2.0 * (weights @ strain**2)) + NOTHING)
    for _ in range(MOST_INVERSIONS):
        s = np.exp(2.0 * rate)
        viscosity, slope = law.expression(s)
        step = (np.log(viscosity) + rate - wanted) / (1.0 + 2.0 * s * slope / viscosity)
        rate -= step
        if np.max(np.abs(step)) <= INVERSION_TOLERANCE:
            break
    return np.asarray(stress * (0.5 * np.exp(rate - wanted)))
