"""The saturation pressure against the reference equation of state of water."""

import numpy as np
import pytest
from CoolProp.CoolProp import PropsSI

from fibermelt.voids import saturation_pressure
from fibermelt.voids.constants import WATER_CRITICAL, WATER_TRIPLE

pytestmark = pytest.mark.verification

IF97_TOLERANCE = 2.5e-4  # what the release of IF97 allows its saturation line to differ
ROUNDING = 1e-12  # of one formula in two libraries, whose fourth power has it


def test_if97_against_wagner_and_pruss():
    # from water's freezing to within a kelvin of its critical point, where both end
    T = np.linspace(274.0, 646.0, 94)
    reference = np.asarray(PropsSI("P", "T", T, "Q", 0.0, "HEOS::Water"))
    assert np.max(np.abs(saturation_pressure(T) / reference - 1.0)) < IF97_TOLERANCE


def test_if97_is_that_of_another_library():
    T = np.linspace(WATER_TRIPLE, WATER_CRITICAL, 94).reshape(2, 47)  # both ends are in
    reference = np.reshape(PropsSI("P", "T", T.ravel(), "Q", 0.0, "IF97::Water"), T.shape)
    assert np.max(np.abs(saturation_pressure(T) / reference - 1.0)) < ROUNDING
