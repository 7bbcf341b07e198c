"""Layers of the bead in a collected sweep: by their number, whatever the height of each bead."""

import numpy as np
import pytest
import xarray as xr

from fibermelt.sweeps.collection import reduce_results, stack

LAYERS = 4


def results(height):
    """Return what a case has over the layers of a bead of a height [m]."""
    middle = (np.arange(LAYERS) + 0.5) * height / LAYERS
    found = xr.Dataset(
        {"void_layer_fiber_pressure": ("void_layer", height * np.arange(LAYERS))},
        {"void_layer": ("void_layer", middle)},
    )
    for name in found.variables:
        found[name].attrs = {"units": "m", "long_name": "made up"}
    return found


# Solvers leave the last digits of a bead's height open; another bead may be twice as high.
@pytest.mark.parametrize("other", [3e-3 * (1 + 1e-12), 6e-3])
def test_cases_share_their_layers_whatever_the_beads_height(other):
    heights = [3e-3, other]
    (batch,) = stack([(str(h), reduce_results(results(h))) for h in heights])
    assert "void_layer" not in batch.variables
    for name in ("void_layer_middle", "void_layer_fiber_pressure"):
        assert batch.variables[name].dimensions == ("case", "void_layer")
        assert batch.variables[name].values.shape == (2, LAYERS)
    expected = np.stack([results(h)["void_layer"].to_numpy() for h in heights])
    np.testing.assert_array_equal(batch.variables["void_layer_middle"].values, expected)
