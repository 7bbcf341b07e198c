"""Second-order orientation tensors: what one must be, its principal axes, its five numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError
from fibermelt.orientation.eigen import eigenframe

__all__ = [
    "TANGENTS",
    "checked_orientation",
    "isotropic",
    "out_of_range",
    "pack",
    "preferred_angle",
    "principal",
    "unpack",
]

Array = NDArray[np.float64]

TENSOR_TOLERANCE = 1e-10
"""Largest asymmetry and largest |trace - 1| of a tensor that is taken: rounding, not an error."""

SAME = 1e-10
"""Difference of two eigenvalues, or in-plane length squared, below which no direction is meant."""


def _tangents() -> Array:
    """Return the five directions d a / d v of ``unpack``."""
    basis = np.zeros((5, 3, 3))
    basis[0] = np.diag([1.0, 0.0, -1.0])
    basis[1] = np.diag([0.0, 1.0, -1.0])
    for k, (i, j) in enumerate(((0, 1), (0, 2), (1, 2)), start=2):
        basis[k, i, j] = basis[k, j, i] = 1.0
    basis.flags.writeable = False
    return basis


TANGENTS = _tangents()
"""(5, 3, 3): symmetric directions without trace, ``TANGENTS[k] = d unpack(v) / d v_k``; read-only.

Independent components in the order (a11, a22, a12, a13, a23), with ``a33 = 1 - a11 - a22``.
"""


def checked_orientation(a: ArrayLike, name: str = "a") -> Array:
    """Return an orientation tensor, or a batch of them, once it is known to be one.

    Parameters
    ----------
    a : (..., 3, 3) array_like
        Second-order orientation tensors [-].
    name : str
        What the message calls it.

    Returns
    -------
    (..., 3, 3) array
        The same numbers as floats, untouched. Eigenvalues outside [0, 1] are not refused, because
        closures leave the cone of true tensors: ``out_of_range`` measures them.

    Raises
    ------
    ConfigError
        If the shape is another, a number is not finite, or asymmetry or |trace - 1| exceed 1e-10.
    """
    tensor = np.array(real_array(name, a))
    if tensor.shape[-2:] != (3, 3):
        msg = f"{name} has shape {tensor.shape}, expected (..., 3, 3): planar tensors stay 3x3"
        raise ConfigError(msg)
    if not np.all(np.isfinite(tensor)):
        msg = f"{name} holds {tensor[~np.isfinite(tensor)][0]}: every component must be finite"
        raise ConfigError(msg)
    if tensor.size == 0:
        return tensor
    asymmetry = np.abs(tensor - tensor.swapaxes(-1, -2))
    if asymmetry.max() > TENSOR_TOLERANCE:
        *where, i, j = np.unravel_index(int(asymmetry.argmax()), tensor.shape)
        one, other = tensor[(*where, i, j)], tensor[(*where, j, i)]
        msg = (
            f"{name} is not symmetric: component {i + 1}{j + 1} is {one:.12g}, {j + 1}{i + 1} is "
            f"{other:.12g} (bound on the difference {TENSOR_TOLERANCE:g}): use (a + a^T)/2"
        )
        raise ConfigError(msg)
    trace = np.trace(tensor, axis1=-2, axis2=-1)
    worst = float(np.ravel(trace)[np.abs(np.ravel(trace) - 1.0).argmax()])
    if abs(worst - 1.0) > TENSOR_TOLERANCE:
        msg = (
            f"{name} has trace {worst:.12g}, an orientation tensor has 1 (bound on the difference "
            f"{TENSOR_TOLERANCE:g}): divide it by its trace"
        )
        raise ConfigError(msg)
    return tensor


def isotropic() -> Array:
    """Return the tensor of fibers in all directions alike, ``I/3``, shape (3, 3)."""
    third: Array = np.eye(3) / 3.0
    return third


def principal(a: ArrayLike) -> tuple[Array, Array]:
    """Return eigenvalues and principal directions, largest first.

    Parameters
    ----------
    a : (..., 3, 3) array
        Symmetric tensors.

    Returns
    -------
    values : (..., 3) array
        Eigenvalues, descending.
    vectors : (..., 3, 3) array
        Unit eigenvectors in the columns, of either sign: ``a = R diag(values) R^T``. Where
        eigenvalues coincide, one orthonormal choice out of many.
    """
    tensors = real_array("a", a)
    if tensors.shape[-2:] != (3, 3):
        msg = f"a has shape {tensors.shape}, expected (..., 3, 3)"
        raise ConfigError(msg)
    values, vectors = eigenframe(tensors.reshape(-1, 3, 3))
    return values.reshape(tensors.shape[:-1]), vectors.reshape(tensors.shape)


def out_of_range(a: ArrayLike) -> Array:
    """Return how far the eigenvalues leave [0, 1], 0 where they do not.

    Parameters
    ----------
    a : (..., 3, 3) array
        Orientation tensors of trace 1.

    Returns
    -------
    (...) array
        Largest of ``-lambda_min`` and ``lambda_max - 1``, at least 0. Rounding shows: a perfectly
        planar tensor may give 1e-17.
    """
    values, _ = principal(a)
    largest: Array = np.maximum(0.0, np.maximum(-values[..., 2], values[..., 0] - 1.0))
    return largest


def preferred_angle(a: ArrayLike) -> Array:
    """Return the in-plane angle of the principal direction (paper Eq. 31).

    Parameters
    ----------
    a : (..., 3, 3) array
        Orientation tensors.

    Returns
    -------
    (...) array
        Angle from the x axis, counter-clockwise, of the projection onto the x-y plane of the
        eigenvector of the largest eigenvalue [rad], in (-pi/2, pi/2]. Never NaN: 0 where there is
        no such direction, that is where the two largest eigenvalues are equal within 1e-10 or the
        eigenvector is normal to the plane (in-plane length squared within 1e-10 of 0).
    """
    values, vectors = principal(a)
    x, y = vectors[..., 0, 0], vectors[..., 1, 0]
    turned = np.arctan2(y, x)
    half_turn = np.where(turned > 0.5 * np.pi, -np.pi, np.where(turned <= -0.5 * np.pi, np.pi, 0.0))
    meant = (values[..., 0] - values[..., 1] > SAME) & (x * x + y * y > SAME)
    angle: Array = np.where(meant, turned + half_turn, 0.0)
    return angle


def pack(a: Array) -> Array:
    """Return the independent components (a11, a22, a12, a13, a23), shape (..., 5)."""
    return np.stack([a[..., 0, 0], a[..., 1, 1], a[..., 0, 1], a[..., 0, 2], a[..., 1, 2]], axis=-1)


def unpack(v: Array) -> Array:
    """Return the tensor of five independent components: symmetric, ``a33 = 1 - a11 - a22``.

    Parameters
    ----------
    v : (..., 5) array
        Components (a11, a22, a12, a13, a23).

    Returns
    -------
    (..., 3, 3) array
        Tensors of trace 1, exactly.
    """
    a = np.empty((*v.shape[:-1], 3, 3), dtype=v.dtype)
    a[..., 0, 0], a[..., 1, 1] = v[..., 0], v[..., 1]
    a[..., 2, 2] = 1.0 - v[..., 0] - v[..., 1]
    a[..., 0, 1] = a[..., 1, 0] = v[..., 2]
    a[..., 0, 2] = a[..., 2, 0] = v[..., 3]
    a[..., 1, 2] = a[..., 2, 1] = v[..., 4]
    return a
