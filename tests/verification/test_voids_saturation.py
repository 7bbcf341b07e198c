"""The saturation pressure against the reference equation of state of water."""

import subprocess
import sys

import numpy as np
import pytest
from patience import PATIENCE

from fibermelt.voids import saturation_pressure

IF97_TOLERANCE = 2.5e-4  # what the release of IF97 allows its saturation line to differ


def test_if97_against_wagner_and_pruss():
    from CoolProp.CoolProp import PropsSI  # noqa: PLC0415  two seconds, for this test only

    # from water's freezing to within a kelvin of its critical point, where both end
    T = np.linspace(274.0, 646.0, 94)
    reference = np.asarray(PropsSI("P", "T", T, "Q", 0.0, "HEOS::Water"))
    assert np.max(np.abs(saturation_pressure(T) / reference - 1.0)) < IF97_TOLERANCE


OURS = "from fibermelt.voids import saturation_pressure; p = float(saturation_pressure(503.15))"
THEIRS = "import CoolProp.CoolProp as C; q = C.PropsSI('P', 'T', 503.15, 'Q', 0, 'Water')"
FROM = "from CoolProp.CoolProp import PropsSI; q = PropsSI('P', 'T', 503.15, 'Q', 0, 'Water')"


@pytest.mark.parametrize("steps", [(OURS, THEIRS), (OURS, FROM, THEIRS), (THEIRS, OURS)])
def test_coolprop_can_be_imported_before_and_after(steps):
    # its compiled module aborts the interpreter if it is loaded a second time
    script = "\n".join(
        [*steps, "assert abs(p / q - 1) < 2.5e-4", "import CoolProp; CoolProp.State"]
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_only_the_compiled_module_is_loaded():
    script = OURS + "; import sys; assert 'CoolProp' not in sys.modules"
    subprocess.run([sys.executable, "-c", script], timeout=PATIENCE, check=True)
