"""Closures of the fourth moment: against fibers, against Carlson's integrals, by identities."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import elliprd

from fibermelt.orientation.closure import Closure
from fibermelt.orientation.closures import CLOSURES
from fibermelt.orientation.exact_closure import central_gaussian
from fibermelt.orientation.tensors import TANGENTS
from fibermelt.verify.averages import sphere_rule
from fibermelt.verify.ladder import Rung, below, order

__all__ = ["RUNGS", "carlson_moments", "central", "deformed_fibers", "generic_tensors"]

Array = NDArray[np.float64]

CARLSON = "Montgomery-Smith et al. 2011, doi 10.1017/jfm.2011.165; Carlson's R_D by scipy"
VERLEYE = "Verleye and Dupret 1993, Developments in Non-Newtonian Flow, ASME AMD-175"
ADVANI = "Advani and Tucker 1987, doi 10.1122/1.549945"

DEFORMATION = np.array([[1.2, 1.0, 0.3], [0.0, 0.9, 0.1], [0.0, 0.2, 1.0]])
"""A shear by one unit with some stretching, out of the plane too."""

POLYNOMIAL = ("linear", "quadratic", "hybrid", "IBOF")
"""Closures that continue to complex components, so that a complex step has no rounding."""

COMPLEX_STEP = 1e-30


def carlson_moments(b: Array) -> Array:
    """Return eigenvalues (n, 3) of ``a`` from those of ``B = (F F^T)^-1`` by Carlson's ``R_D``.

    Parameters
    ----------
    b : (n, 3) array
        Eigenvalues of ``B`` [-], positive.

    References
    ----------
    Montgomery-Smith et al. 2011, doi 10.1017/jfm.2011.165.
    """
    b1, b2, b3 = b.T
    found = [elliprd(b2, b3, b1), elliprd(b3, b1, b2), elliprd(b1, b2, b3)]
    return np.asarray(np.stack(found, axis=1) / 3)


def deformed_fibers(F: Array, points: int) -> tuple[Array, Array]:
    """Return second and fourth moments of random fibers after a deformation, fiber by fiber.

    Parameters
    ----------
    F : (3, 3) array
        What turns ``p`` into ``F p/|F p|``.
    points : int
        Of the rule, from pole to pole; its error falls exponentially.
    """
    p, weight = sphere_rule(points)
    q = p @ F.T
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    pairs = np.einsum("ni,nj->nij", q, q)
    second = np.einsum("n,nij->ij", weight, pairs)
    return second, np.einsum("n,nij,nkl->ijkl", weight, pairs, pairs, optimize=True)


def generic_tensors() -> Array:
    """Return tensors (3, 3, 3) in general position, with eigenvalues 0.1 or more apart."""
    values = np.array([[0.6, 0.3, 0.1], [0.5, 0.35, 0.15], [0.8, 0.15, 0.05]])
    axes, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3, 3)))
    return np.asarray(np.einsum("nik,nk,njk->nij", axes, values, axes))


def central(law: Closure, a: Array, step: float) -> Array:
    """Return a closure's derivatives along all admissible directions by central differences."""
    up = law.fourth(a[:, None] + step * TANGENTS)
    down = law.fourth(a[:, None] - step * TANGENTS)
    return (up - down) / (2.0 * step)


def _exact() -> tuple[float, float, float]:
    """Return errors of the exact closure: fibers, Carlson's integrals, the plane."""
    law = CLOSURES["exact"]
    a, A = deformed_fibers(DEFORMATION, 120)
    values = np.concatenate(
        [
            np.random.default_rng(2).dirichlet([0.5, 0.5, 0.5], 200).clip(1e-12),
            np.array([[1 - 2 * small, small, small] for small in 10.0 ** -np.arange(1, 12)]),
        ]
    )
    carlson = carlson_moments(central_gaussian(values)) / values - 1.0
    planar = []
    for split in (0.5, 0.7, 0.95):
        flat = law.fourth(np.diag([split, 1.0 - split, 0.0]))
        expected = 0.5 * split * np.array([1.0 + split, 1.0 - split])
        planar.append(np.max(np.abs([flat[0, 0, 0, 0], flat[0, 0, 1, 1]] - expected)))
    return (
        float(np.max(np.abs(law.fourth(a) - A))),
        float(np.max(np.abs(carlson))),
        float(max(planar)),
    )


def _identities() -> tuple[float, float, float]:
    """Return errors of the trace of every closure, and of derivatives."""
    a = generic_tensors()
    kept = [law for law in CLOSURES.values() if law.keeps_normalization]
    traces = [np.einsum("nijkk->nij", law.fourth(a)) - a for law in kept]
    stepped = [
        CLOSURES[name].fourth(a[:, None] + 1j * COMPLEX_STEP * TANGENTS).imag / COMPLEX_STEP
        - CLOSURES[name].fourth_derivative(a, TANGENTS)
        for name in POLYNOMIAL
    ]
    exact = CLOSURES["exact"]
    slope = exact.fourth_derivative(a, TANGENTS)
    coarse, fine = (np.max(np.abs(central(exact, a, h) - slope)) for h in (2e-3, 1e-3))
    return (
        float(np.max(np.abs(traces))),
        float(np.max(np.abs(stepped))),
        float(np.log2(coarse / fine)),
    )


RUNGS = (
    Rung(
        "orientation",
        (
            below(
                "closure: exact, against fibers",
                "Fourth moment by the exact closure against that of random fibers, each turned "
                "by one deformation.",
                ADVANI,
                1e-12,
                "the fibers' rule has converged, and the closure is exact for them: rounding",
            ),
            below(
                "closure: exact, against Carlson",
                "Second moment from the exact closure's parameters against elliptic integrals, "
                "relative, from random to aligned within 1e-11.",
                CARLSON,
                1e-12,
                "both are good to a few roundings, also of eigenvalues of 1e-11",
            ),
            below(
                "closure: exact, in the plane",
                "Fourth moment of planar orientation by the exact closure against L (1 + L)/2 and "
                "L (1 - L)/2.",
                VERLEYE,
                5e-12,
                "the third eigenvalue is the closure's smallest, 1e-12, not zero",
            ),
        ),
        _exact,
        quick=True,
        brief=True,
    ),
    Rung(
        "orientation",
        (
            below(
                "closures: trace",
                "A_ijkk of every closure that keeps it against a_ij.",
                ADVANI,
                1e-11,
                "IBOF's coefficients reach 1e10 and cancel to numbers of order one",
            ),
            below(
                "closures: derivatives by a complex step",
                "Derivatives of the linear, quadratic, hybrid and IBOF closures against complex "
                "steps of 1e-30.",
                "Squire and Trapp 1998, doi 10.1137/S003614459631241X",
                1e-11,
                "IBOF's coefficients reach 1e10 and cancel to numbers of order one",
            ),
            order(
                "closure: exact, order of differences",
                "Order in which central differences of the exact closure become its derivative, "
                "steps of 2e-3 and 1e-3.",
                "Taylor's theorem",
                (1.95, 2.05),
                "second order; the next term is (1e-3/0.1)^2 of it",
            ),
        ),
        _identities,
        quick=True,
        brief=True,
    ),
)
