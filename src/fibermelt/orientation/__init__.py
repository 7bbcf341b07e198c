"""Orientation of many fibers: second-order tensors, their closures, and what moves them.

The tensor ``a_ij = <p_i p_j>`` is the second moment of the orientation distribution (Advani and
Tucker 1987, doi:10.1122/1.549945): symmetric, of trace 1, eigenvalues in [0, 1]. It stays 3x3 in
planar flow. Every function takes arrays (..., 3, 3) of any batch.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fibermelt.orientation.closures import CLOSURES, Closure
    from fibermelt.orientation.evolve import OrientationHistory, follow_orientation
    from fibermelt.orientation.flows import FLOWS, flow_gradient
    from fibermelt.orientation.models import (
        ARDRSC,
        IARD,
        MODELS,
        MRD,
        PARD,
        RSC,
        FolgarTucker,
        Jeffery,
        Nematic,
        OrientationModel,
        model_class,
        shape_factor,
    )
    from fibermelt.orientation.steady import SteadyState, steady_state
    from fibermelt.orientation.tensors import isotropic, out_of_range, preferred_angle, principal

_HOMES = {
    "closures": ("CLOSURES", "Closure"),
    "evolve": ("OrientationHistory", "follow_orientation"),
    "flows": ("FLOWS", "flow_gradient"),
    "models": (
        "ARDRSC",
        "IARD",
        "MODELS",
        "MRD",
        "PARD",
        "RSC",
        "FolgarTucker",
        "Jeffery",
        "Nematic",
        "OrientationModel",
        "model_class",
        "shape_factor",
    ),
    "steady": ("SteadyState", "steady_state"),
    "tensors": ("isotropic", "out_of_range", "preferred_angle", "principal"),
}
"""Module to the public names that it has; none may be that of a module, which would hide it."""

__all__ = [
    "ARDRSC",
    "CLOSURES",
    "FLOWS",
    "IARD",
    "MODELS",
    "MRD",
    "PARD",
    "RSC",
    "Closure",
    "FolgarTucker",
    "Jeffery",
    "Nematic",
    "OrientationHistory",
    "OrientationModel",
    "SteadyState",
    "flow_gradient",
    "follow_orientation",
    "isotropic",
    "model_class",
    "out_of_range",
    "preferred_angle",
    "principal",
    "shape_factor",
    "steady_state",
]


def __getattr__(name: str) -> Any:
    """Load a public name from its module."""
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"fibermelt.orientation.{module}"), name)
    msg = f"module 'fibermelt.orientation' has no attribute {name!r}"
    raise AttributeError(msg)


def __dir__() -> list[str]:
    """Return the public names, loaded or not."""
    return list(__all__)
