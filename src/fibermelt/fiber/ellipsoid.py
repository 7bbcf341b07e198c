"""A rigid ellipsoid in an unbounded melt: how it turns, and the stress on its surface.

Put a traction ``T n`` on the surface, ``T`` a constant tensor (symmetric for a free particle). With
``Psi = int_V dV/r`` and ``chi = int_V r dV`` over the ellipsoid's body, the Stokeslets add up to

    u = L x + (1/(8 pi mu)) T_jk (2 delta_ij d_k Psi - d_i d_j d_k chi),
    p = p_inf - (1/(4 pi)) T_jk d_j d_k Psi,

the flow around Eshelby's inclusion in an incompressible medium. Inside, ``Psi`` is quadratic and
``chi`` quartic, hence ``u`` linear in ``x``: it can be a rigid rotation, and then no other traction
is at work. Matching (integrals of `fibermelt.fiber.ellipsoid_integrals`, body axes, no sum over i):

    T_ij = 4 mu D_ij / ((a_i^2 + a_j^2) I_ij),  i != j,
    T_ii = 4 mu w_i D_ii / (w_1 w_2 + w_2 w_3 + w_3 w_1),   w_1 = K_23, w_2 = K_31, w_3 = K_12,
    omega_1 = Omega_1 + (a_2^2 - a_3^2)/(a_2^2 + a_3^2) D_23  and cyclic (Jeffery 1922),

up to a multiple of the identity in ``T``, which stirs nothing. ``d_i d_j Psi`` is ``-2 pi I_i
delta_ij`` inside and jumps by ``4 pi n_i n_j`` on the way out. So on the surface

    p - p_inf = -n . Sigma n,     Sigma = T - (1/2) (I_1 T_11 + I_2 T_22 + I_3 T_33) identity.

``Sigma`` is the traction's own tensor, isotropic part included: no slip makes ``n . D n`` vanish on
the surface, so that ``p = -n . sigma n`` there. Every unit vector ``n`` is a normal somewhere: the
extreme pressures are the outer eigenvalues of ``-Sigma``, exactly, at the points whose normals are
its eigenvectors. The sphere gives ``Sigma = 5 mu D``.

References
----------
Jeffery 1922, doi 10.1098/rspa.1922.0078; Eshelby 1959, doi 10.1098/rspa.1959.0173 (the inclusion's
potentials); Kim and Karrila 1991, "Microhydrodynamics", chapter 3 (the linear traction).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConfigError, refuse_other
from fibermelt.fiber.checks import checked_gradient, checked_positive, checked_unit
from fibermelt.fiber.directions import equal_area_directions, even_frames
from fibermelt.fiber.ellipsoid_integrals import ellipsoid_integrals
from fibermelt.fiber.symmetric import (
    Components,
    Vector,
    blocks,
    components,
    extreme_eigenpairs,
    strain_ends,
    vector,
)

__all__ = ["Ellipsoid", "EllipsoidResponse", "SurfaceExtremes", "unbounded_ellipsoid"]

Array = NDArray[np.float64]

CYCLIC = ((1, 2), (2, 0), (0, 1))
"""The two other axes of each axis, in the order that turns right-handed."""


PAIRS = ((1, 2), (0, 2), (0, 1))
"""Rows and columns of the components of a symmetric matrix off its diagonal, in their order."""

SHAPES = 61
"""Kinds of strain, from axisymmetric stretching to compression, for which the mildest is sought."""

FRAMES = 1000
"""Orientations among which it is sought."""

STARTS = 4
"""How many of them are turned on, from the mildest up."""

TURNS = 60
"""Times that each of those is turned about `WAYS` axes, by 0.2 rad at first and half as much when
that did not help."""

WAYS = 24


@dataclass(frozen=True)
class Ellipsoid:
    """A rigid ellipsoid.

    Parameters
    ----------
    semi_axes : tuple of three floats
        ``a_1, a_2, a_3`` [m], positive, in any order.

    Raises
    ------
    ConfigError
        If there are not three, or one is not positive and finite.
    """

    semi_axes: tuple[float, float, float]

    def __post_init__(self) -> None:
        """Refuse what is no body."""
        if real_array("fiber.semi_axes", self.semi_axes).shape != (3,):
            axes = self.semi_axes
            msg = f"fiber.semi_axes = {axes}: must be three; a spheroid has two equal ones"
            raise ConfigError(msg)
        for k, value in enumerate(self.semi_axes):
            checked_positive(f"fiber.semi_axes[{k}]", value, "m", "42e-6")


@dataclass(frozen=True, eq=False)
class SurfaceExtremes:
    """Lowest and highest pressure on a surface, and where.

    Points on the surface are given by the vector of their eccentric angles, ``e_i = x_i/a_i`` in
    body axes: a unit vector, (1, 0, 0) at the tip of the first axis. The opposite point sees the
    same pressure; the one with ``e_1 >= 0`` is given. Where a pressure is reached along a curve or
    everywhere, it is one of the points.

    Parameters
    ----------
    lowest, highest : (...) array
        ``(p - p_inf)/mu`` [1/s].
    where_lowest, where_highest : (..., 3) array
        Eccentric vectors [-]; the axes are those of the gradient that was given.
    """

    lowest: Array
    highest: Array
    where_lowest: Array
    where_highest: Array


@dataclass(frozen=True, eq=False)
class EllipsoidResponse:
    """The linear response of a force- and torque-free ellipsoid, in its own axes.

    Parameters
    ----------
    semi_axes : (3,) array
        ``a_i`` [m].
    shape_factors : (3,) array
        ``(a_j^2 - a_k^2)/(a_j^2 + a_k^2)`` [-] of the rotation about axis i.
    stiffness : (3, 3) array
        ``T_ij/(mu D_ij)`` [-], up to a multiple of the identity in ``T``.
    depolarisation : (3,) array
        ``I_i/2`` [-], of sum one.
    """

    semi_axes: Array
    shape_factors: Array
    stiffness: Array
    depolarisation: Array

    def angular_velocity(self, gradient: ArrayLike) -> Array:
        """Return the torque-free angular velocity in body axes [1/s], (..., 3).

        Parameters
        ----------
        gradient : (..., 3, 3) array_like
            Velocity gradient of the far field in body axes [1/s].

        Raises
        ------
        HistoryError
            If a gradient is not finite or has a trace; so for all that follow.
        """
        L = checked_gradient(gradient, 3)
        parts = []
        for factor, (j, k) in zip(self.shape_factors, CYCLIC, strict=True):
            melt = 0.5 * (L[..., k, j] - L[..., j, k])
            parts.append(melt + factor * 0.5 * (L[..., k, j] + L[..., j, k]))
        return np.stack(parts, axis=-1)

    def surface_stress(self, gradient: ArrayLike) -> Array:
        """Return ``Sigma/mu`` [1/s], (..., 3, 3), for the traction ``Sigma n - p_inf n``.

        Parameters
        ----------
        gradient : (..., 3, 3) array_like
            Velocity gradient of the far field in body axes [1/s].
        """
        S = self._stress(components(checked_gradient(gradient, 3)))
        rows = [[S[0], S[5], S[4]], [S[5], S[1], S[3]], [S[4], S[3], S[2]]]
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)

    def surface_pressure(self, gradient: ArrayLike, where: ArrayLike) -> Array:
        """Return ``(p - p_inf)/mu`` [1/s] at points of the surface.

        Parameters
        ----------
        gradient : (..., 3, 3) array_like
            Velocity gradient of the far field in body axes [1/s].
        where : (..., 3) array_like
            Eccentric vectors ``x_i/a_i`` of the points [-], of length one; broadcast with the
            gradients.

        Raises
        ------
        HistoryError, ConfigError
            If a gradient is not finite or has a trace; if a point is not on the surface.
        """
        normal = checked_unit(where, "where") * (np.min(self.semi_axes) / self.semi_axes)
        normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
        stress = self.surface_stress(gradient)
        return np.asarray(-np.einsum("...i,...ij,...j->...", normal, stress, normal))

    def extremes(self, gradient: ArrayLike) -> SurfaceExtremes:
        """Return the lowest and highest surface pressure, and where, in body axes.

        Parameters
        ----------
        gradient : (..., 3, 3) array_like
            Velocity gradient of the far field in body axes [1/s].
        """
        L = checked_gradient(gradient, 3)
        shape = L.shape[:-2]
        lowest, highest = np.empty(shape), np.empty(shape)
        places = np.empty((*shape, 3)), np.empty((*shape, 3))
        for block in blocks(shape):
            strain = components(L[block])
            low, high, at_low, at_high = extreme_eigenpairs(self._stress(strain))
            # pressure is minus the stress: the largest eigenvalue is the lowest pressure
            lowest[block], highest[block] = -high, -low
            for place, normal in zip(places, (at_high, at_low), strict=True):
                for k, part in enumerate(self._eccentric(normal)):
                    place[(*block, ..., k)] = part
        return SurfaceExtremes(lowest, highest, *places)

    def turned_extremes(
        self, gradient: ArrayLike, first: ArrayLike, second: ArrayLike
    ) -> SurfaceExtremes:
        """Return the same along the axes of the flow, for bodies turned to any frame.

        All arguments broadcast.

        Parameters
        ----------
        gradient : (..., 3, 3) array_like
            Velocity gradient of the far field [1/s].
        first, second : (..., 3) array_like
            The body's first and second axes, unit vectors at right angles; the third makes them
            right-handed.
        """
        L, p, q = self._turned(gradient, first, second)
        shape = L.shape[:-2]
        lowest, highest = np.empty(shape), np.empty(shape)
        places = np.empty((*shape, 3)), np.empty((*shape, 3))
        for block in blocks(shape):
            axes = _frame(vector(p[block]), vector(q[block]))
            stress = self._stress(_in_frame(components(L[block]), axes))
            low, high, at_low, at_high = extreme_eigenpairs(stress)
            lowest[block], highest[block] = -high, -low
            for place, normal in zip(places, (at_high, at_low), strict=True):
                e = self._eccentric(normal)
                for k in range(3):
                    part = e[0] * axes[0][k] + e[1] * axes[1][k] + e[2] * axes[2][k]
                    place[(*block, ..., k)] = part
        return SurfaceExtremes(lowest, highest, *places)

    def turned_values(
        self, gradient: ArrayLike, first: ArrayLike, second: ArrayLike
    ) -> tuple[Array, Array]:
        """Return ``lowest, highest`` of `turned_extremes` without the places."""
        L, p, q = self._turned(gradient, first, second)
        shape = L.shape[:-2]
        lowest, highest = np.empty(shape), np.empty(shape)
        for block in blocks(shape):
            axes = _frame(vector(p[block]), vector(q[block]))
            stress = self._stress(_in_frame(components(L[block]), axes))
            low, high, _, _ = extreme_eigenpairs(stress)
            lowest[block], highest[block] = -high, -low
        return lowest, highest

    def _turned(
        self, gradient: ArrayLike, first: ArrayLike, second: ArrayLike
    ) -> tuple[Array, Array, Array]:
        """Return gradients and frames of one shape."""
        L = checked_gradient(gradient, 3)
        p, q = checked_unit(first, "first"), checked_unit(second, "second")
        shape = np.broadcast_shapes(L.shape[:-2], p.shape[:-1], q.shape[:-1])
        return (
            np.broadcast_to(L, (*shape, 3, 3)),
            np.broadcast_to(p, (*shape, 3)),
            np.broadcast_to(q, (*shape, 3)),
        )

    def bounds(self, gradient: ArrayLike) -> tuple[Array, Array]:
        """Return the lowest and the highest ``(p - p_inf)/mu`` [1/s] over every orientation.

        The pressure where the normal is ``n`` is ``G(n) : D`` with ``G_ij = N_i k_ii delta_ij -
        k_ij n_i n_j`` in body axes (stiffness ``k``, depolarisation ``N``), and over all turns at
        most the eigenvalues of both, paired in order (see `fibermelt.fiber.spheroid_bounds`). That
        is largest for a normal along an axis, as the tests find among all normals for bodies of any
        axes; for spheroids it is proved there.

        Parameters
        ----------
        gradient : (..., 3, 3) array_like
            Velocity gradients [1/s].
        """
        low, high = strain_ends(checked_gradient(gradient, 3))
        return -self._worst(-high, -low), self._worst(low, high)

    def _worst(self, low: Array, high: Array) -> Array:
        """Return the highest pressure over every orientation from the ends of the strain."""
        own = np.diag(self.stiffness)
        found = []
        for k in range(3):
            least, middle, most = np.sort(self.depolarisation * own - own * (np.arange(3) == k))
            found.append(most * high - middle * (low + high) + least * low)
        return np.asarray(np.max(found, axis=0))

    def mildest(self, gradient: ArrayLike) -> tuple[Array, Array]:
        """Return the lowest and the highest ``(p - p_inf)/mu`` [1/s] where they are mildest.

        Sought from `FRAMES` orientations on and linear between `SHAPES` kinds of strain: at most
        3 % above a spheroid's own, which is known.

        Parameters
        ----------
        gradient : (..., 3, 3) array_like
            Velocity gradients [1/s].
        """
        low, high = strain_ends(checked_gradient(gradient, 3))
        half, middle = 0.5 * (high - low), 0.5 * (high + low)
        kind = middle / np.where(half > 0.0, half, 1.0)
        kinds, values = self._mildest
        return -half * np.interp(-kind, kinds, values), half * np.interp(kind, kinds, values)

    @cached_property
    def _mildest(self) -> tuple[Array, Array]:
        """Return kinds of strain ``diag(1 + k, -2 k, k - 1)`` and their mildest highest pressure.

        ``k`` lies between -1/3 and 1/3.
        """
        k = np.linspace(-1.0, 1.0, SHAPES) / 3.0
        strain = np.zeros((SHAPES, 1, 3, 3))
        for axis, part in enumerate((1.0 + k, -2.0 * k, k - 1.0)):
            strain[:, 0, axis, axis] = part
        first = even_frames(FRAMES)
        _, highest = self.turned_values(strain, first[..., 0], first[..., 1])
        best = np.argsort(highest, axis=1)[:, :STARTS]
        frames, values = first[best], np.take_along_axis(highest, best, axis=1)
        angle = np.full(values.shape, 0.2)
        axes = equal_area_directions(WAYS, whole_sphere=True)
        for _ in range(TURNS):
            tried = _rotations(axes, angle) @ frames[:, :, None]
            _, found = self.turned_values(strain[:, :, None], tried[..., 0], tried[..., 1])
            way = found.argmin(axis=2)[..., None]
            milder = np.take_along_axis(found, way, axis=2)[..., 0]
            helps = milder < values
            turned = np.take_along_axis(tried, way[..., None, None], axis=2)[:, :, 0]
            frames = np.where(helps[..., None, None], turned, frames)
            values = np.minimum(milder, values)
            angle = np.where(helps, angle, 0.5 * angle)
        return k, values.min(axis=1)

    def _stress(self, D: Components) -> Components:
        """Return the components of ``Sigma/mu`` in body axes, from those of the strain there."""
        k, (n1, n2, n3) = self.stiffness, self.depolarisation
        a, b, c = (k[i, i] * D[i] for i in range(3))
        rest = n1 * a + n2 * b + n3 * c
        d, e, f = (k[i, j] * part for (i, j), part in zip(PAIRS, D[3:], strict=True))
        return a - rest, b - rest, c - rest, d, e, f

    def _eccentric(self, normal: Vector) -> Vector:
        """Return the eccentric vector where the normal is ``n``: ``a_i n_i``, with ``e_1 >= 0``."""
        axes = self.semi_axes / np.max(self.semi_axes)
        x, y, z = (axis * part for axis, part in zip(axes, normal, strict=True))
        inverse = np.where(x < 0.0, -1.0, 1.0) / np.sqrt(x * x + y * y + z * z)
        return x * inverse, y * inverse, z * inverse

    @property
    def tip_stiffness(self) -> float:
        """Return ``-(p_tip - p_inf)/mu`` at the first axis per unit of ``D = diag(1, -1/2, -1/2)``.

        5 for the sphere; 31.07 for the prolate spheroid of aspect ratio 6.
        """
        return float(self.surface_stress(np.diag([1.0, -0.5, -0.5]))[0, 0])


def unbounded_ellipsoid(body: Ellipsoid) -> EllipsoidResponse:
    """Return the response of an ellipsoid in an unbounded melt, exact to rounding.

    Parameters
    ----------
    body : Ellipsoid
        The particle; only the ratios of its axes matter. Spheroids and the sphere are no special
        cases: every integral is a sum of positive terms.

    Raises
    ------
    ConfigError
        If it is none.
    """
    refuse_other("body", body, Ellipsoid)
    a = np.array(body.semi_axes, dtype=np.float64)
    a = a / np.max(a)
    integrals = ellipsoid_integrals(a, np.array(0.0))
    square = a * a
    stiffness = 4.0 / ((square[:, None] + square) * integrals.double)
    w = np.array([integrals.moment[j, k] for j, k in CYCLIC])
    np.fill_diagonal(stiffness, 4.0 * w / (w[0] * w[1] + w[1] * w[2] + w[2] * w[0]))
    factors = np.array([(a[j] - a[k]) * (a[j] + a[k]) / (a[j] ** 2 + a[k] ** 2) for j, k in CYCLIC])
    return EllipsoidResponse(
        np.array(body.semi_axes, dtype=np.float64), factors, stiffness, 0.5 * integrals.single
    )


def _rotations(axes: Array, angle: Array) -> Array:
    """Return the rotations (..., k, 3, 3) about ``k`` axes by angles (...) [rad]."""
    x, y, z = axes.T
    none = np.zeros_like(x)
    cross = np.stack([none, -z, y, z, none, -x, -y, x, none], axis=-1).reshape(-1, 3, 3)
    s, c = (f(angle)[..., None, None, None] for f in (np.sin, np.cos))
    return np.asarray(np.eye(3) + s * cross + (1.0 - c) * cross @ cross)


def _frame(p: Vector, q: Vector) -> tuple[Vector, Vector, Vector]:
    """Return three axes, the third at right angles to both."""
    r = (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])
    return p, q, r


def _in_frame(D: Components, axes: tuple[Vector, Vector, Vector]) -> Components:
    """Return the components of a symmetric matrix along other axes."""
    a, b, c, d, e, f = D
    p, q, r = axes
    images = [
        (a * x + f * y + e * z, f * x + b * y + d * z, e * x + d * y + c * z) for x, y, z in axes
    ]

    def along(u: Vector, v: Vector) -> Array:
        return np.asarray(u[0] * v[0] + u[1] * v[1] + u[2] * v[2])

    first, second, third = images
    return (
        along(first, p),
        along(second, q),
        along(third, r),
        along(second, r),
        along(first, r),
        along(first, q),
    )
