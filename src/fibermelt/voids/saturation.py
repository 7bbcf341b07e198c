"""The saturation pressure of water, from CoolProp."""

from __future__ import annotations

import importlib.util
from functools import cache
from importlib.machinery import PathFinder
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.voids.checks import checked_range
from fibermelt.voids.constants import WATER_CRITICAL, WATER_TRIPLE

__all__ = ["saturation_pressure"]

Array = NDArray[np.float64]


@cache
def _properties() -> ModuleType:
    """Return CoolProp's compiled module without running its package's ``__init__``.

    That one reads the equations of state of every fluid, two seconds; IF97 needs none of them.
    """
    package = importlib.util.find_spec("CoolProp")
    locations = package.submodule_search_locations if package else None
    spec = PathFinder.find_spec("CoolProp.CoolProp", locations)
    if spec is None or spec.loader is None:
        msg = "CoolProp is not installed: pip install coolprop"
        raise ImportError(msg)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def saturation_pressure(temperature: ArrayLike) -> Array:
    """Return the saturation pressure of water [Pa, absolute].

    IAPWS-IF97, region 4, as implemented by CoolProp (Bell et al. 2014, doi 10.1021/ie4033999);
    within 0.025 % of the reference equation of state of Wagner and Pruss 2002
    (doi 10.1063/1.1461829), which is the tolerance of that release.

    Parameters
    ----------
    temperature : (...,) array_like
        Temperature [K], from the triple point, 273.16 K, to the critical point, 647.096 K.

    Returns
    -------
    (...,) array
        2.797 MPa at 503.15 K (230 degC).

    Raises
    ------
    ConfigError
        If a temperature is outside that range.
    """
    T = checked_range(
        "temperature",
        temperature,
        (WATER_TRIPLE, WATER_CRITICAL),
        "K",
        "water has a saturation pressure between its triple and its critical point only",
    )
    found = _properties().PropsSI("P", "T", np.atleast_1d(T).ravel(), "Q", 0.0, "IF97::Water")
    return np.asarray(found, dtype=np.float64).reshape(T.shape)
