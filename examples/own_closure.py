"""
A closure of your own
=====================

A closure gives the fourth moment of the orientation from the second. A value with four methods is
enough; here two of them follow from the formula by a complex step, which is exact to rounding. The
formula is Advani and Tucker's hybrid closure, with the weight of their paper of 1987 and that of
1990; the second ships as ``closure("hybrid")``, and must come out the same.
"""

from collections.abc import Callable
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np

import fibermelt as fm
from fibermelt.orientation.closure import Closure
from fibermelt.orientation.polynomial import LinearLaw, QuadraticLaw

STEP = 1e-30  # nothing is subtracted: as small as can be


@dataclass(frozen=True)
class Blend:
    """``A = (1 - f) A_linear + f A_quadratic``, arrays (..., 3, 3) of any batch."""

    weight: Callable[[np.ndarray], np.ndarray]

    def fourth(self, a):
        """Return ``A`` (..., 3, 3, 3, 3)."""
        f = self.weight(a)[..., None, None, None, None]
        return (1 - f) * LinearLaw().fourth(a) + f * QuadraticLaw().fourth(a)

    def fourth_derivative(self, a, da):
        """Return its derivatives along k directions ``da`` (..., k, 3, 3)."""
        return self.fourth(a[..., None, :, :] + 1j * STEP * da).imag / STEP

    def contract(self, a, D):
        """Return ``A:D``."""
        return np.einsum("...ijkl,...kl->...ij", self.fourth(a), D)

    def contract_derivative(self, a, D, da):
        """Return the derivatives of ``A:D`` with respect to ``a``."""
        return np.einsum("...xijkl,...kl->...xij", self.fourth_derivative(a, da), D)


def by_norm(a):
    """Return ``f = 3/2 a:a - 1/2`` (Advani and Tucker 1987)."""
    return 1.5 * np.einsum("...ij,...ij->...", a, a) - 0.5


def by_determinant(a):
    """Return ``f = 1 - 27 det a`` (Advani and Tucker 1990)."""
    return 1 - 27 * np.einsum("...i,...i->...", a[..., 0, :], np.cross(a[..., 1, :], a[..., 2, :]))


def hybrid(name, weight):
    """Return the closure as a value that everything in `fibermelt.orientation` takes."""
    return Closure(
        name=name,
        source="Advani and Tucker",
        law=Blend(weight),
        is_fully_symmetric=False,
        keeps_normalization=True,
        validity="exact for random and for perfectly aligned fibers",
    )


# %%
# The angle at which most fibers lie in simple shear, over the interaction coefficient. Both weights
# overstate how well fibers are aligned; the closure named exact is there to compare with.

closures = {
    "by the norm": hybrid("norm", by_norm),
    "by the determinant": hybrid("determinant", by_determinant),
    "shipped": fm.closure("hybrid"),
    "exact": fm.closure("exact"),
}
shear = [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
xi = fm.unbounded_model("ellipse", fm.Ellipse(42e-6, aspect_ratio=6.0)).response.shape_factor
interactions = np.geomspace(3e-3, 0.1, 12)
angles = {
    name: [fm.steady_state(fm.FolgarTucker(xi, C_I), shear, own).angle for C_I in interactions]
    for name, own in closures.items()
}
difference = np.abs(np.subtract(angles["by the determinant"], angles["shipped"])).max()
print(f"off from the shipped one by {difference:.0e} rad")

figure, axes = plt.subplots(layout="constrained")
for name, style in (("by the norm", "-"), ("by the determinant", "-"), ("exact", "k--")):
    axes.semilogx(interactions, angles[name], style, label=name)
axes.set(xlabel="interaction coefficient C_I", ylabel="preferred angle [rad]")
axes.legend()
plt.show()
