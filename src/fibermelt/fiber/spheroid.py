"""A rigid spheroid in an unbounded melt: many fibers, any gradient, any direction, at once.

`fibermelt.fiber.ellipsoid` with two equal axes, freed from its body axes. For a director ``p``

    p_dot = W p + xi (D p - (p.D p) p),                         xi = (r_e^2 - 1)/(r_e^2 + 1),
    Sigma/mu = c_t D + (c_s - c_t)(p (D p)^T + (D p) p^T) + (c_a + c_t - 2 c_s)(p.D p) p p^T
               - c_o (p.D p) identity,

with ``c_a, c_s, c_t`` the answers to stretching along the axis, to shear of the axis and to strain
across it, and ``c_o = N_a c_a - N_b c_t`` (depolarisation factors ``N``). Where the normal is
``n`` the pressure is ``p_inf - n.Sigma n``: its extremes over the surface are eigenvalues. At tips

    p_tip - p_inf = -mu (c_a - c_o) p.D p.

References: Jeffery 1922, doi 10.1098/rspa.1922.0078; Junk and Illner 2007,
doi 10.1007/s00021-005-0208-0 (Jeffery's equation for any body).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, HistoryError, refuse_other
from fibermelt.fiber.checks import checked_gradient, checked_positive, checked_unit
from fibermelt.fiber.ellipsoid import Ellipsoid, SurfaceExtremes, unbounded_ellipsoid
from fibermelt.fiber.shape import jeffery_factor
from fibermelt.fiber.spheroid_bounds import mildest_pressure, orientation_bound
from fibermelt.fiber.symmetric import (
    Components,
    Vector,
    blocks,
    components,
    extreme_eigenpairs,
    strain_ends,
    vector,
)

__all__ = ["Spheroid", "SpheroidResponse", "embed_planar", "unbounded_spheroid"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Spheroid:
    """A rigid fiber or disc: an ellipsoid of revolution.

    Parameters
    ----------
    half_length : float
        Semi-axis ``a`` along the axis of revolution [m], positive. It sets no pressure.
    aspect_ratio : float
        ``r_e = a/b`` [-], positive: above one prolate, below one oblate.

    Raises
    ------
    ConfigError
        If one is not positive and finite.
    """

    half_length: float
    aspect_ratio: float

    def __post_init__(self) -> None:
        """Refuse what is no fiber."""
        checked_positive("fiber.half_length", self.half_length, "m", "42e-6")
        checked_positive("fiber.aspect_ratio", self.aspect_ratio, "", "6")

    @property
    def radius(self) -> float:
        """Return ``b = a/r_e`` [m]."""
        return self.half_length / self.aspect_ratio

    @property
    def jeffery_factor(self) -> float:
        """Return ``xi`` [-], negative for a disc."""
        return jeffery_factor(self.aspect_ratio)

    def as_ellipsoid(self) -> Ellipsoid:
        """Return the same body with its three semi-axes, the axis of revolution first."""
        return Ellipsoid((self.half_length, self.radius, self.radius))


@dataclass(frozen=True)
class SpheroidResponse:
    """How a free spheroid turns and what its surface sees, for any gradient and direction.

    All methods broadcast gradients (..., 3, 3) with directions (..., 3); a planar gradient goes
    through `embed_planar` first. They raise HistoryError for a gradient that is not finite or has
    a trace, ConfigError for a direction that is not a unit vector.

    Parameters
    ----------
    aspect_ratio : float
        ``r_e`` [-].
    shape_factor : float
        ``xi`` [-].
    axial, shear, transverse, offset : float
        ``c_a, c_s, c_t, c_o`` [-] of the module's docstring.
    """

    aspect_ratio: float
    shape_factor: float
    axial: float
    shear: float
    transverse: float
    offset: float

    def rate(self, gradient: ArrayLike, direction: ArrayLike) -> Array:
        """Return ``p_dot`` [1/s], (..., 3): Jeffery's equation."""
        L, p = checked_gradient(gradient, 3), checked_unit(direction)
        along = np.einsum("...ij,...j->...i", L, p)
        back = np.einsum("...ji,...j->...i", L, p)
        strain = 0.5 * (along + back)
        stretch = np.einsum("...i,...i->...", strain, p)[..., None]
        return np.asarray(0.5 * (along - back) + self.shape_factor * (strain - stretch * p))

    def angular_velocity(self, gradient: ArrayLike, direction: ArrayLike) -> Array:
        """Return ``omega = Omega + xi p x (D p)`` [1/s], (..., 3), with the spin about the axis.

        About its axis the spheroid turns with the melt, ``omega.p = Omega.p``.
        """
        L, p = checked_gradient(gradient, 3), checked_unit(direction)
        D = 0.5 * (L + np.swapaxes(L, -1, -2))
        melt = 0.5 * np.stack(
            [
                L[..., 2, 1] - L[..., 1, 2],
                L[..., 0, 2] - L[..., 2, 0],
                L[..., 1, 0] - L[..., 0, 1],
            ],
            axis=-1,
        )
        turn = np.cross(p, np.einsum("...ij,...j->...i", D, p))
        return np.asarray(melt + self.shape_factor * turn)

    def surface_stress(self, gradient: ArrayLike, direction: ArrayLike) -> Array:
        """Return ``Sigma/mu`` [1/s], (..., 3, 3): the traction is ``Sigma n - p_inf n``."""
        S = self._stress(checked_gradient(gradient, 3), vector(checked_unit(direction)))
        rows = [[S[0], S[5], S[4]], [S[5], S[1], S[3]], [S[4], S[3], S[2]]]
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

    def tip(self, gradient: ArrayLike, direction: ArrayLike) -> Array:
        """Return ``(p - p_inf)/mu`` [1/s] at the two tips, (...)."""
        L, p = checked_gradient(gradient, 3), checked_unit(direction)
        stretch = np.einsum("...i,...ij,...j->...", p, L, p)
        return np.asarray((self.offset - self.axial) * stretch)

    def extremes(self, gradient: ArrayLike, direction: ArrayLike) -> SurfaceExtremes:
        """Return the lowest and highest surface pressure and where, exact to rounding.

        The places are eccentric vectors along the axes of the gradient, on the half ``e.p >= 0``:
        the point is ``x = b e + (a - b)(e.p) p``, its eccentric angle from the tip ``arccos(e.p)``.
        """
        L, p = checked_gradient(gradient, 3), checked_unit(direction)
        shape = np.broadcast_shapes(L.shape[:-2], p.shape[:-1])
        L, p = np.broadcast_to(L, (*shape, 3, 3)), np.broadcast_to(p, (*shape, 3))
        lowest, highest = np.empty(shape), np.empty(shape)
        places = np.empty((*shape, 3)), np.empty((*shape, 3))
        for block in blocks(shape):
            axis = vector(p[block])
            low, high, at_low, at_high = extreme_eigenpairs(self._stress(L[block], axis))
            # pressure is minus the stress: the largest eigenvalue is the lowest pressure
            lowest[block], highest[block] = -high, -low
            for place, normal in zip(places, (at_high, at_low), strict=True):
                for k, part in enumerate(self._eccentric(normal, axis)):
                    place[(*block, ..., k)] = part
        return SurfaceExtremes(lowest, highest, *places)

    def extreme_values(self, gradient: ArrayLike, direction: ArrayLike) -> tuple[Array, Array]:
        """Return ``lowest, highest`` of `extremes` without the places, at half the cost."""
        L, p = checked_gradient(gradient, 3), checked_unit(direction)
        shape = np.broadcast_shapes(L.shape[:-2], p.shape[:-1])
        L, p = np.broadcast_to(L, (*shape, 3, 3)), np.broadcast_to(p, (*shape, 3))
        lowest, highest = np.empty(shape), np.empty(shape)
        for block in blocks(shape):
            low, high, _, _ = extreme_eigenpairs(self._stress(L[block], vector(p[block])))
            lowest[block], highest[block] = -high, -low
        return lowest, highest

    def eccentric_angle(self, where: ArrayLike, direction: ArrayLike) -> Array:
        """Return how far from the tip a place of `extremes` is [rad], 0 to pi/2 at the equator."""
        e, p = checked_unit(where, "where"), checked_unit(direction)
        across = np.linalg.norm(np.cross(e, p), axis=-1)
        return np.asarray(np.arctan2(across, np.abs(np.einsum("...i,...i->...", e, p))))

    def bounds(self, gradient: ArrayLike) -> tuple[Array, Array]:
        """Return the lowest and the highest ``(p - p_inf)/mu`` [1/s] over every direction.

        Exact for any gradient, no direction is sampled: see `fibermelt.fiber.spheroid_bounds`.

        Parameters
        ----------
        gradient : (..., 3, 3) array_like
            Velocity gradients [1/s].
        """
        low, high = strain_ends(checked_gradient(gradient, 3))
        constants = (self.axial, self.transverse, self.offset)
        return -orientation_bound(constants, -high, -low), orientation_bound(constants, low, high)

    def mildest(self, gradient: ArrayLike) -> tuple[Array, Array]:
        """Return the lowest and the highest ``(p - p_inf)/mu`` [1/s] where they are mildest.

        Each in the direction of its own that suffers least from it: see
        `fibermelt.fiber.spheroid_bounds`.

        Parameters
        ----------
        gradient : (..., 3, 3) array_like
            Velocity gradients [1/s].
        """
        low, high = strain_ends(checked_gradient(gradient, 3))
        constants = (self.axial, self.shear, self.transverse, self.offset)
        return -mildest_pressure(constants, -high, -low), mildest_pressure(constants, low, high)

    def _stress(self, L: Array, p: Vector) -> Components:
        """Return the components of ``Sigma/mu`` for the directors' components ``p``."""
        a, b, c, d, e, f = components(L)
        x, y, z = p
        u, v, w = a * x + f * y + e * z, f * x + b * y + d * z, e * x + d * y + c * z
        stretch = u * x + v * y + w * z
        t, pair = self.transverse, self.shear - self.transverse
        half = 0.5 * (self.axial + t - 2.0 * self.shear) * stretch
        rest = self.offset * stretch
        # the symmetric part of 2 (pair D p + half p) p^T
        u, v, w = pair * u + half * x, pair * v + half * y, pair * w + half * z
        return (
            t * a + 2.0 * u * x - rest,
            t * b + 2.0 * v * y - rest,
            t * c + 2.0 * w * z - rest,
            t * d + v * z + w * y,
            t * e + u * z + w * x,
            t * f + u * y + v * x,
        )

    def _eccentric(self, normal: Vector, p: Vector) -> Vector:
        """Return ``e ~ b n + (a - b)(n.p) p`` over its length, with ``e.p >= 0``."""
        x, y, z = normal
        cosine = x * p[0] + y * p[1] + z * p[2]
        lift = (self.aspect_ratio - 1.0) * cosine
        x, y, z = x + lift * p[0], y + lift * p[1], z + lift * p[2]
        inverse = np.where(cosine < 0.0, -1.0, 1.0) / np.sqrt(x * x + y * y + z * z)
        return x * inverse, y * inverse, z * inverse


def unbounded_spheroid(fiber: Spheroid) -> SpheroidResponse:
    """Return the response of a spheroid in an unbounded melt, exact to rounding.

    Prolate, oblate and the sphere are one case: see `fibermelt.fiber.ellipsoid_integrals`.

    Parameters
    ----------
    fiber : Spheroid
        The fiber; its size does not matter.

    Raises
    ------
    ConfigError
        If it is none.
    """
    refuse_other("fiber", fiber, Spheroid)
    general = unbounded_ellipsoid(fiber.as_ellipsoid())
    # across the axis both stiffnesses agree but for rounding
    axial, transverse = float(general.stiffness[0, 0]), float(general.stiffness[1, 1])
    along, across, _ = (float(part) for part in general.depolarisation)
    return SpheroidResponse(
        fiber.aspect_ratio,
        fiber.jeffery_factor,
        axial,
        float(general.stiffness[0, 1]),
        transverse,
        along * axial - across * transverse,
    )


def embed_planar(gradient: ArrayLike) -> Array:
    """Return planar velocity gradients in three dimensions, (..., 3, 3): nothing happens along z.

    Parameters
    ----------
    gradient : (..., 2, 2) array_like
        ``L[..., i, j] = d u_i/d x_j`` [1/s].

    Raises
    ------
    ConfigError
        If the gradients are not 2 x 2.
    HistoryError
        If a gradient is not finite or has a trace.
    """
    L = real_array("gradient", gradient, error=HistoryError)
    if L.shape[-2:] != (2, 2):
        msg = f"gradient has shape {L.shape}, expected (..., 2, 2)"
        raise ConfigError(msg)
    checked_gradient(L, 2)
    embedded = np.zeros((*L.shape[:-2], 3, 3))
    embedded[..., :2, :2] = L
    return embedded
