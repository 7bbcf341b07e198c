"""Rates of the orientation models: their Jacobians, which Newton's method rests on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fibermelt.fiber.shape import jeffery_factor
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.models import (
    ARDRSC,
    IARD,
    MRD,
    PARD,
    RSC,
    FolgarTucker,
    Jeffery,
    Nematic,
    OrientationModel,
)
from fibermelt.orientation.tensors import TANGENTS
from fibermelt.verify.closures import generic_tensors
from fibermelt.verify.distribution import random_gradient
from fibermelt.verify.ladder import Rung, below

__all__ = ["RUNGS"]

Array = NDArray[np.float64]

FACTOR = jeffery_factor(6.0)

MODELS: tuple[OrientationModel, ...] = (
    Jeffery(FACTOR),
    FolgarTucker(FACTOR, 0.05),
    RSC(FACTOR, 0.05, 0.3),
    ARDRSC(FACTOR, 1.924e-4, 5.839e-3, 0.04, 1.168e-5, 0.0, kappa=0.1),
    IARD(FACTOR, 0.05, 0.6),
    PARD(FACTOR, 0.05, 0.7),
    MRD(FACTOR, 0.05),
    Nematic(FACTOR, 0.05, 0.05),
)
"""All there are; the coefficients of the fourth are Phelps and Tucker's."""

STEP = 2e-3
"""Of the coarser difference: a fiftieth of the smallest gap between eigenvalues."""


def _jacobians() -> tuple[float]:
    """Return the largest error of a derivative over its model's largest, models and closures."""
    a, L, errors = generic_tensors(), random_gradient(5), []
    for model in MODELS:
        for name in ("IBOF", "ORE", "exact"):
            closure = CLOSURES[name]
            steps = []
            for h in (STEP, 0.5 * STEP):
                up, down = (
                    model.rate(a[:, None] + sign * h * TANGENTS, L, closure) for sign in (1, -1)
                )
                steps.append((up - down) / (2.0 * h))
            exact = model.derivative(a, L, closure, TANGENTS)
            extrapolated = (4.0 * steps[1] - steps[0]) / 3.0
            errors.append(np.max(np.abs(extrapolated - exact)) / np.max(np.abs(exact)))
    return (float(max(errors)),)


RUNGS = (
    Rung(
        "orientation",
        (
            below(
                "models: Jacobian",
                "Derivative of the rate of eight models with three closures against extrapolated "
                "differences, over the largest.",
                "Richardson 1911, doi 10.1098/rsta.1911.0009",
                1e-6,
                "the fourth power of the step over the eigenvalues' smallest gap, (1/50)^4 = "
                "1.6e-7, a few times",
            ),
        ),
        _jacobians,
        quick=True,
        brief=True,
    ),
)
