"""The saturation pressure of water, from seuif97."""

from __future__ import annotations

import numpy as np
import seuif97
from numpy.typing import ArrayLike, NDArray

from fibermelt.voids.checks import checked_range
from fibermelt.voids.constants import ICE_POINT, WATER_CRITICAL, WATER_TRIPLE

__all__ = ["saturation_pressure"]

Array = NDArray[np.float64]

MPA = 1e6
"""What the library's unit of pressure is [Pa]; its temperatures are in degrees Celsius."""


def saturation_pressure(temperature: ArrayLike) -> Array:
    """Return the saturation pressure of water [Pa, absolute].

    IAPWS-IF97, region 4 (Wagner et al. 2000, doi 10.1115/1.483186), as implemented by seuif97;
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
    found = [seuif97.tx2p(float(one) - ICE_POINT, 0.0) for one in T.ravel()]
    return MPA * np.array(found, dtype=np.float64).reshape(T.shape)
