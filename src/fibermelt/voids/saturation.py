"""The saturation pressure of water, from CoolProp."""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from importlib.machinery import PathFinder
from types import ModuleType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.voids.checks import checked_range
from fibermelt.voids.constants import WATER_CRITICAL, WATER_TRIPLE

__all__ = ["saturation_pressure"]

Array = NDArray[np.float64]

_COMPILED = "CoolProp.CoolProp"


@cache
def _properties() -> ModuleType:
    """Return CoolProp's compiled module without running its package's ``__init__``.

    That one reads the equations of state of every fluid, two seconds; IF97 needs none of them. The
    module is entered under its own name, so that whoever imports the package later gets the same:
    loaded twice, it aborts the interpreter.
    """
    if _COMPILED in sys.modules:
        return sys.modules[_COMPILED]
    package = importlib.util.find_spec("CoolProp")
    locations = package.submodule_search_locations if package else None
    spec = PathFinder.find_spec(_COMPILED, locations) if locations else None
    if spec is None or spec.loader is None:
        msg = "the saturation pressure of water needs CoolProp: pip install coolprop"
        raise ImportError(msg)
    module = importlib.util.module_from_spec(spec)
    sys.modules[_COMPILED] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[_COMPILED]
        raise
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
