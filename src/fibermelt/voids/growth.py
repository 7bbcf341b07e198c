"""A nucleus that grows, shrinks and dissolves along a path: a bubble in its cell of melt.

A bubble of radius ``R`` in the middle of a ball of melt of radius ``S``, ``S^3 - R^3`` constant,
with water vapor of the mass ``m`` in it and dissolved water around it:

- Momentum, ``p_b - p - 2 sigma/R = T``. The melt is stretched at
  ``g x``, ``g = 2 sqrt(3) R'/R``, ``x = (R/r)^3``, so that
  ``T = 4 (R'/R) integral of eta over x from (R/S)^3 to 1``: ``4 mu (R'/R) [1 - (R/S)^3]`` of a
  Newtonian melt, ``(4 K/n) (2 sqrt 3)^(n-1) (R'/R)^n [1 - (R/S)^(3n)]`` of a power law. In a melt
  that flows at the rate ``gamma_dot`` itself, ``eta`` is that of ``sqrt(gamma_dot^2 + (g x)^2)``:
  the mean of ``D:D`` over all directions, in which the two do not mix.
- Vapor, an ideal gas in balance with the melt at its surface: ``p_b V = m R_g T/M``, ``c = k p_b``.
- Diffusion. ``y = (r^3 - R^3)/3`` goes with the melt: ``c_t = D (r^4 c_y)_y``, no flux at ``S``.
  A ladder of shells, whose volumes and whose distances grow by one factor ``q`` from shell to
  shell: volumes reach to ``sqrt(q)`` times where concentrations stand, as in the grids that are
  best for the flux into a half-space (Ingerman, Druskin and Knizhnerman 2000). Resistances are
  those of steady flux between spheres. Second order in ``ln q``.

What a shell gives the next one gets, so that water is conserved to rounding. Where a bubble is
large against its layer it grows as ``R = 2 beta sqrt(D t)``, ``beta = sqrt(3/pi) Ja``,
``Ja = (c - k p)/rho_g`` (Scriven 1959), where it is small its layer is steady, ``4 pi R D`` times
the difference (Epstein and Plesset 1950): both are limits of the same ladder.

A nucleus sits in a crevice: it never gets smaller than it is there.

References
----------
Barlow and Langlois 1962 (momentum of a bubble in a melt); Amon and Denson, Polym. Eng. Sci. 24
(1984) 1026 (cells); Scriven, Chem. Eng. Sci. 10 (1959) 1, doi 10.1016/0009-2509(59)80019-1;
Epstein and Plesset, J. Chem. Phys. 18 (1950) 1505; Ingerman, Druskin and Knizhnerman, Comm. Pure
Appl. Math. 53 (2000) 1039.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fibermelt.arrays import real_array
from fibermelt.errors import ConvergenceError, HistoryError
from fibermelt.melt import ViscosityLaw
from fibermelt.voids.checks import checked_range, checked_value, refuse_no_path
from fibermelt.voids.constants import GAS_CONSTANT, WATER_MOLAR_MASS

__all__ = ["BubbleMelt", "Growth", "Surroundings", "grow", "viscous_resistance"]

Array = NDArray[np.float64]

STRETCH = 2.0 * math.sqrt(3.0)
"""Rate of deformation at a bubble's surface over ``R'/R``: ``sqrt(2 D:D)``, ``D`` of
``diag(-2, 1, 1) R'/R``."""

RATIO = 5.0
"""Largest ratio of the volumes of neighbouring shells around a nucleus in a large cell: from 5 of
them around one of 5 um to 12 around one of 0.1 um at the tip of a fiber. What they are off by is in
docs/verification.md."""

FEWEST = 4
"""Shells in a cell not much larger than its nucleus."""

FIRST = 0.1
"""Volume of the first shell over that of the nucleus, about: a layer of 0.02/3 of its radius."""

STEPS = 8
"""Steps between two stations, on the coarsest mesh in time."""

HALVINGS = 7
"""How often they are halved at most: to 1024."""

MARCHED = 3
"""Levels of steps that every nucleus is followed on: two tell no error of the second order."""

TOLERANCE = 0.05
"""Largest error of ``ln R`` at stations, as the last halving tells it; about as much is left of
nuclei that are just critical, a tenth of others."""

RESTING = 1e-12
"""Rate [1/s] below which a melt is at rest: laws take the logarithm of theirs."""

LADDER = np.append(0.0, np.geomspace(1e-6, 1.0, 49))
"""Knots between two stations besides the path's own points, as parts of the time between."""

SMALLEST_RATIO = 1.2
"""Of the volumes of neighbouring shells: of a cell not much larger than its nucleus."""

SPHERE = 1e-3
"""Distance of the foci over the half-length below which a spheroid is taken as this one: off by a
millionth."""

FULL = 0.99
"""Largest share of gas in bubble and cell: a melt that is under tension all over has no other end,
it tears."""

BLOCK = 4096
"""Nuclei that are followed at once: what they need stays in a core's cache."""

GRADED = 3.0
"""Power of the variable of integration: of a law that turns level, the more even the higher."""

NODES, WEIGHTS = 0.5 * np.array(np.polynomial.legendre.leggauss(8))
NODES += 0.5
"""Gauss and Legendre's rule on 0 to 1."""

SETTLED = 1e-4
"""Largest last change of Newton's steps, relative: they double the digits, 1e-8 is left."""

STILL = 1e-13
"""A step's growth of ``ln R`` below which it is none."""

MOST_STEPS = 60
"""Newton's steps at most; three or four are usual."""


@dataclass(frozen=True)
class BubbleMelt:
    """What a melt with moisture in it is to a bubble.

    Parameters
    ----------
    vapor_pressure : float
        ``P_V`` of the moisture before any bubble grows [Pa, absolute], at least 0.
    solubility : float
        ``k``: dissolved water in the volume of melt for its vapor pressure [kg/(m3 Pa)], > 0.
    diffusivity : float
        ``D`` of the water [m2/s], at least 0; 0: the gas of the nucleus is all there is.
    tension : float
        Surface tension ``sigma`` [N/m], at least 0.
    temperature : float
        Of melt and vapor [K], > 0.
    law : ViscosityLaw, optional
        How the melt thins; by default it does not.
    """

    vapor_pressure: float
    solubility: float
    diffusivity: float
    tension: float
    temperature: float
    law: ViscosityLaw | None = None

    def __post_init__(self) -> None:
        """Refuse what is no melt."""
        checked_value("vapor_pressure", self.vapor_pressure, "Pa", least=0.0)
        checked_value("solubility", self.solubility, "kg/(m3 Pa)", above=0.0)
        checked_value("diffusivity", self.diffusivity, "m2/s", least=0.0)
        checked_value("tension", self.tension, "N/m", least=0.0)
        checked_value("temperature", self.temperature, "K", above=0.0)

    @property
    def gas(self) -> float:
        """Return ``R_g T/M``: pressure over density of the vapor [J/kg]."""
        return GAS_CONSTANT * self.temperature / WATER_MOLAR_MASS


@dataclass(frozen=True, eq=False)
class Growth:
    """Nuclei in time: at ``k`` times, every `STEPS`-th of them a station.

    Parameters
    ----------
    time : (..., k) array
        Time [s].
    radius : (..., k) array
        ``R`` [m].
    vapor : (..., k) array
        Mass of the vapor in the bubble [kg].
    dissolved : (..., k) array
        Mass of the water in its cell of melt [kg].
    error : (..., k) array
        Estimated error of ``ln R``, by what half of the steps have otherwise.
    """

    time: Array
    radius: Array
    vapor: Array
    dissolved: Array
    error: Array

    def at_stations(self, name: str) -> Array:
        """Return one of its arrays at the stations, (..., s)."""
        whole: Array = getattr(self, name)[..., STEPS::STEPS]
        return whole


def viscous_resistance(
    rate: ArrayLike, squeezed: ArrayLike, law: ViscosityLaw, flow_rate: ArrayLike = 0.0
) -> tuple[Array, Array]:
    """Return the melt's resistance ``T`` [Pa] to a bubble, and ``dT/d(R'/R)`` [Pa s].

    Parameters
    ----------
    rate : (...) array_like
        ``R'/R`` [1/s], negative of a bubble that shrinks.
    squeezed : (...) array_like
        ``(R/S)^3`` [-], from 0 to below 1; the share of gas in bubble and cell.
    law : ViscosityLaw
        Of the melt.
    flow_rate : (...) array_like
        Rate of deformation of the melt without the bubble ``gamma_dot`` [1/s], at least 0.

    Notes
    -----
    By Gauss and Legendre's rule with eight points in ``v``, ``x = v^(3/n)``, ``n`` the index at
    the bubble's surface: of a power law at rest the integrand is ``v^2``, which is exact; of laws
    that turn level it is within 0.3 %. The derivative is in closed form.
    """
    e, x_S, gamma = np.broadcast_arrays(
        checked_range("rate", rate, (-np.inf, np.inf), "1/s"),
        checked_range("squeezed", squeezed, (0.0, 1.0)),
        checked_range("flow_rate", flow_rate, (0.0, np.inf), "1/s"),
    )
    return _resistance(e, x_S, law, gamma)


def _resistance(e: Array, x_S: Array, law: ViscosityLaw, gamma: Array) -> tuple[Array, Array]:
    """Return `viscous_resistance` of what is in range."""
    g = STRETCH * np.abs(e)
    squared = gamma * gamma

    def total(x: Array) -> Array:
        return np.asarray(np.maximum(np.sqrt(squared + (g * x) ** 2), RESTING))

    at_surface = total(np.ones_like(x_S))
    n = 1.0 + (law.index_at(at_surface) - 1.0) * (g / at_surface) ** 2
    lowest = x_S ** (n / GRADED)
    mean = np.zeros_like(g)
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        v = lowest + (1.0 - lowest) * node
        x = v ** (GRADED / n)
        mean += weight * law.viscosity_at(total(x)) * x / v
    mean *= (1.0 - lowest) * GRADED / n
    slope = 4.0 * (law.viscosity_at(at_surface) - x_S * law.viscosity_at(total(x_S)))
    return 4.0 * e * mean, slope


@dataclass(frozen=True, eq=False)
class Tip:
    """The tip of a fiber: how far from it the pressure on it is felt.

    Creeping flow has a harmonic pressure: its mean over a ball is that in the middle. So a bubble
    of radius ``R`` at the tip feels what the fiber alone makes of the pressure at the distance
    ``R``, on the axis of a fiber that is stretched along it:

    - of an ellipse ``(1 - m)/(zeta^2 - m)``, ``m = (a - b)/(a + b)``, with
      ``a + R = ((a + b)/2)(zeta + m/zeta)`` (the pressure of conformal mapping, docs/theory);
    - of a spheroid ``f(a + R)/f(a)``, ``f(x) = 2 c x/(x^2 - c^2) - ln((x + c)/(x - c))``,
      ``c^2 = a^2 - b^2``: stresslets in proportion to ``c^2 - s^2`` between the foci (Chwang and
      Wu 1975, part 2).

    Parameters
    ----------
    half_length, half_width : float
        Semi-axes ``a > b > 0`` of the fiber [m].
    in_space : bool
        Whether it is a spheroid: or an ellipse, a cylinder across a plane flow.

    References
    ----------
    Chwang and Wu, J. Fluid Mech. 67 (1975) 787, doi 10.1017/S0022112075000614.
    """

    half_length: float
    half_width: float
    in_space: bool

    def __post_init__(self) -> None:
        """Refuse what is no fiber."""
        checked_value("half_width", self.half_width, "m", above=0.0)
        checked_value("half_length", self.half_length, "m", least=self.half_width)

    def share(self, radius: Array) -> Array:
        """Return which part of the tip's pressure over the melt's a bubble feels, 1 to 0."""
        a, b = self.half_length, self.half_width
        if self.in_space:
            return np.asarray(self._spheroid(radius) / self._spheroid(np.zeros(())))
        m = (a - b) / (a + b)
        zeta = (a + radius + np.sqrt(radius * (2.0 * a + radius) + b * b)) / (a + b)
        return np.asarray((1.0 - m) / (zeta * zeta - m))

    def _spheroid(self, distance: Array) -> Array:
        """Return ``f`` at a distance from the tip [m], a sphere as if its foci were apart."""
        a, b = self.half_length, self.half_width
        c = max(math.sqrt(a * a - b * b), SPHERE * a)
        beyond = distance * (2.0 * a + distance) + a * a - c * c
        u = c / (a + distance)
        return np.asarray(2.0 * (c * (a + distance) / beyond - np.arctanh(u)))


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What nuclei meet on their paths, linear in time between points, and level after the last.

    Parameters
    ----------
    time : (..., n) array_like
        Time [s], strictly increasing along the last axis; the leading axes of all go by
        broadcasting.
    pressure : (..., n) array_like
        In the melt around the nucleus ``p`` [Pa, **absolute**].
    viscosity : (..., n) array_like
        Of the melt as it flows without a bubble [Pa s], > 0.
    flow_rate : (..., n) array_like
        Rate of deformation of the melt as it flows [1/s], at least 0, for a melt that thins.
    fiber_pressure : (..., n) array_like
        What a fiber adds to the pressure at its tip [Pa].
    tip : Tip, optional
        The tip, where there is a fiber.

    Raises
    ------
    HistoryError
        If shapes disagree, a value is not finite or time does not increase.
    ConfigError
        If a value is out of its range.
    """

    time: ArrayLike
    pressure: ArrayLike
    viscosity: ArrayLike
    flow_rate: ArrayLike = 0.0
    fiber_pressure: ArrayLike = 0.0
    tip: Tip | None = None

    def arrays(self) -> tuple[Array, ...]:
        """Return time, pressure, viscosity, flow rate and fiber's pressure, all of one shape."""
        t = real_array("time", self.time, error=HistoryError, duration=True)
        p = real_array("pressure", self.pressure, error=HistoryError)
        refuse_no_path(t, "pressure", p)
        eta = checked_range("viscosity", self.viscosity, (0.0, np.inf), "Pa s", positive=True)
        rate = checked_range("flow_rate", self.flow_rate, (0.0, np.inf), "1/s")
        fiber = checked_range("fiber_pressure", self.fiber_pressure, (-np.inf, np.inf), "Pa")
        try:
            return tuple(np.broadcast_arrays(t, p, eta, rate, fiber))
        except ValueError as error:
            msg = (
                f"time {t.shape}, pressure {p.shape}, viscosity {eta.shape}, flow_rate "
                f"{rate.shape} and fiber_pressure {fiber.shape} do not go together: paths are "
                "along the last axis of all"
            )
            raise HistoryError(msg) from error


def grow(
    around: Surroundings,
    melt: BubbleMelt,
    radius: ArrayLike,
    cell_volume: ArrayLike,
    stations: ArrayLike,
    tolerance: float = TOLERANCE,
) -> Growth:
    """Return how nuclei grow along paths.

    Parameters
    ----------
    around : Surroundings
        The paths, their leading axes (...) with those of what follows by broadcasting.
    melt : BubbleMelt
        What the melt is.
    radius : (...) array_like
        Of the nucleus in its crevice ``R_0`` [m], > 0; vapor is in it, in balance with the melt.
    cell_volume : (...) array_like
        Of melt around a nucleus [m3], > 0.
    stations : (..., s) array_like
        Times [s] that are told exactly, increasing along the last axis, after the first point.
    tolerance : float
        Steps are halved until the estimated error of ``ln R`` is below it, or `HALVINGS` times.

    Raises
    ------
    HistoryError
        If shapes disagree, a value is not finite or time does not increase.
    ConfigError
        If a value is out of its range.
    ConvergenceError
        If Newton's method finds no step.
    """
    R_0, volume = (
        checked_range(name, one, (0.0, np.inf), unit, positive=True)
        for name, one, unit in (("radius", radius, "m"), ("cell_volume", cell_volume, "m3"))
    )
    paths = _paths(around, stations)
    try:
        group = np.arange(math.prod(paths.shape)).reshape(paths.shape)
        group, R_0, volume = np.broadcast_arrays(group, R_0, volume)
    except ValueError as error:
        msg = (
            f"paths of shape {paths.shape}, radius of {R_0.shape} and cell_volume of "
            f"{volume.shape} do not go together: give one for each path, or one"
        )
        raise HistoryError(msg) from error
    meshes = _Meshes(paths, melt.vapor_pressure)
    nuclei = _Nuclei(melt, around.tip, group.ravel(), R_0.ravel(), volume.ravel())
    time = meshes.times(0, range(len(paths.time)))
    found = np.empty((4, time.shape[-1], group.size))
    for which in nuclei.blocks():
        found[..., which] = _extrapolated(meshes, nuclei.some(which), tolerance)
    grown, vapor, dissolved, off = np.moveaxis(found, 1, -1).reshape(4, *group.shape, -1)
    time = time[group.ravel()].reshape(grown.shape)
    return Growth(time, R_0[..., None] * np.exp(grown), vapor, dissolved, off)


@dataclass(frozen=True, eq=False)
class _Paths:
    """Paths one by one: points (path, n), stations (path, s), and the shape that they had."""

    time: Array
    pressure: Array
    viscosity: Array
    flow_rate: Array
    fiber_pressure: Array
    stations: Array
    shape: tuple[int, ...]


def _paths(around: Surroundings, stations: ArrayLike) -> _Paths:
    """Return checked paths."""
    arrays = around.arrays()
    told = real_array("stations", stations, error=HistoryError, duration=True)
    if told.ndim == 0 or told.size == 0:
        msg = f"stations of shape {told.shape}: give at least one time, along the last axis"
        raise HistoryError(msg)
    try:
        shape = np.broadcast_shapes(arrays[0].shape[:-1], told.shape[:-1])
    except ValueError as error:
        msg = (
            f"paths of shape {arrays[0].shape[:-1]} and stations of {told.shape} do not go "
            "together: give stations for each path, or the same for all"
        )
        raise HistoryError(msg) from error
    rows = [
        np.broadcast_to(one, (*shape, one.shape[-1])).reshape(-1, one.shape[-1])
        for one in (*arrays, told)
    ]
    ends = np.concatenate([rows[0][:, :1], rows[-1]], axis=1)
    if not np.all(np.isfinite(told)) or np.any(np.diff(ends) <= 0.0):
        msg = "stations must be finite, increase, and lie after the first point of their path"
        raise HistoryError(msg)
    t, p, eta, rate, fiber, told = rows
    return _Paths(t, p, eta, rate, fiber, told, shape)


@dataclass(frozen=True, eq=False)
class _Mesh:
    """Steps in time of several paths: their lengths and the means over them, (k, path)."""

    step: Array
    pressure: Array
    viscosity: Array
    flow_rate: Array
    fiber_pressure: Array

    def steps(self) -> Iterator[tuple[Array, ...]]:
        """Iterate over the steps: its length and the means of all paths."""
        return zip(self.step, *(getattr(self, name) for name in MEANS), strict=True)


MEANS = ("pressure", "viscosity", "flow_rate", "fiber_pressure")
"""What is taken as its mean over a step."""


class _Meshes:
    """Meshes in time for paths, each with half the steps of the one before.

    Between two stations the steps share evenly: time itself, its logarithm from the beginning on in
    units of the time of growth, the exponent ``integral |P_V - p|/(4 eta)``, and the pressure's ups
    and downs.
    """

    def __init__(self, paths: _Paths, vapor_pressure: float) -> None:
        self._paths = paths
        self._places = [self._place(k, vapor_pressure) for k in range(len(paths.time))]
        values = np.stack([getattr(paths, name) for name in MEANS], axis=1)
        self._integrals = [_Integral(*one) for one in zip(paths.time, values, strict=True)]
        self._steps: dict[tuple[int, int], Array] = {}

    def times(self, level: int, which: Sequence[int] | NDArray[np.intp]) -> Array:
        """Return the times of ``2^level`` times `STEPS` steps between stations, (path, k + 1)."""
        share = np.linspace(0.0, 1.0, STEPS * 2**level + 1)
        return np.array([self._nodes(share, self._places[k]) for k in which])

    def at(self, level: int, which: NDArray[np.intp]) -> _Mesh:
        """Return the steps of some paths."""
        for k in which:
            if (level, k) not in self._steps:
                self._refine(level, k)
        return _Mesh(*np.stack([self._steps[level, k] for k in which], axis=-1))

    def _refine(self, level: int, k: int) -> None:
        """Have a path's steps of some level, and of those below, whose times are among its own."""
        finest = max(level, MARCHED - 1)
        (time,) = self.times(finest, [k])
        whole = np.concatenate([time[None], self._integrals[k](time)])
        for each in range(finest + 1):
            step, *over = np.diff(whole[:, :: 2 ** (finest - each)])
            self._steps[each, k] = np.stack([step, *(one / step for one in over)])

    @staticmethod
    def _nodes(share: Array, places: list[tuple[Array, Array]]) -> Array:
        """Return the times of a path's steps: `share` of what lies between any two stations."""
        parts = [np.interp(share, weight, knots) for knots, weight in places]
        return np.concatenate([parts[0], *(part[1:] for part in parts[1:])])

    def _place(self, k: int, vapor_pressure: float) -> list[tuple[Array, Array]]:
        """Return knots and how many of the steps lie before them, for each part of a path."""
        t, p, eta, _, fiber = (getattr(self._paths, one)[k] for one in ("time", *MEANS))
        drive = (vapor_pressure - p - fiber) / (4.0 * eta)
        ends = self._paths.stations[k]
        # Nothing happens before the pressure is first below the vapor's.
        below = np.flatnonzero((drive > 0.0) & (t < ends[0]))
        begin = t[max(below[0] - 1, 0)] if below.size else t[0]
        places = []
        for end in ends:
            inside = t[(t > begin) & (t < end)]
            knots = np.sort(np.concatenate([begin + (end - begin) * LADDER, inside]))
            local = np.interp(knots, t, drive)
            size = np.abs(local)
            fastest = max(float(np.max(size)), 1.0 / (end - begin))
            weights = (
                knots - begin,
                np.log1p(fastest * (knots - begin)),
                np.append(0.0, np.cumsum(0.5 * (size[1:] + size[:-1]) * np.diff(knots))),
                np.append(0.0, np.cumsum(np.abs(np.diff(local)))),
            )
            weight = sum(one / one[-1] for one in weights if one[-1] > 0.0)
            places.append((knots, weight / weight[-1]))
            begin = end
        return places


class _Integral:
    """The integrals of polylines from their first point on, level after the last."""

    def __init__(self, time: Array, values: Array) -> None:
        step = np.diff(time)
        self._time, self._values = time, values
        self._slope = np.append(np.diff(values) / step, np.zeros((len(values), 1)), axis=1)
        mean = 0.5 * (values[:, 1:] + values[:, :-1])
        self._whole = np.append(np.zeros((len(values), 1)), np.cumsum(mean * step, axis=1), axis=1)

    def __call__(self, time: Array) -> Array:
        """Return all integrals up to times (k) after the first point, (polyline, k)."""
        j = np.searchsorted(self._time, time, side="right") - 1
        past = time - self._time[j]
        half = self._values[:, j] + 0.5 * self._slope[:, j] * past
        return np.asarray(self._whole[:, j] + half * past)


def _extrapolated(
    meshes: _Meshes, nuclei: _Nuclei, tolerance: float
) -> tuple[Array, Array, Array, Array]:
    """Return ``ln R/R_0``, masses of vapor and of dissolved water, and the error, (k, nuclei).

    Euler's steps are off in proportion to their length: twice what half of it gives less the whole
    is off by its square, which the next halving tells and takes away. Nuclei that it tells too much
    of are followed again by twice as many steps.
    """
    left = np.arange(nuclei.R_0.size)
    before, coarse = (_marched(meshes, level, nuclei) for level in (0, 1))
    first = 2.0 * coarse - before
    told = np.empty((4, *first.shape[1:]))
    for level in range(MARCHED - 1, HALVINGS + 1):
        fine = _marched(meshes, level, nuclei.some(left))
        second = 2.0 * fine - coarse
        told[:3, :, left] = second + (second - first) / 3.0
        told[3, :, left] = np.abs(second[0] - first[0]).T
        off = np.max(told[3, STEPS::STEPS, left], axis=1) > tolerance
        left, coarse, first = left[off], fine[..., off], second[..., off]
        if left.size == 0:
            break
    # Between growing and being held they may differ in sign: no nucleus leaves its crevice so.
    grown, vapor, dissolved, error = told
    return np.maximum(grown, 0.0), vapor, dissolved, error


@dataclass(frozen=True, eq=False)
class _Nuclei:
    """Nuclei one by one: the path of each, its radius and its cell's volume, all (nuclei)."""

    melt: BubbleMelt
    tip: Tip | None
    path: NDArray[np.intp]
    R_0: Array
    volume: Array

    @property
    def shells(self) -> NDArray[np.intp]:
        """Return how many shells of melt each is followed in."""
        room = np.maximum(self.volume / (4.0 / 3.0 * np.pi * self.R_0**3) / FIRST, 1.0)
        counts = np.ceil(np.log(room) / math.log(RATIO) + 0.5).astype(np.intp)
        return np.maximum(counts, FEWEST)

    def blocks(self) -> Iterator[NDArray[np.intp]]:
        """Iterate over those that are followed at once: of one number of shells."""
        shells = self.shells
        for count in np.unique(shells):
            alike = np.flatnonzero(shells == count)
            yield from (alike[k : k + BLOCK] for k in range(0, alike.size, BLOCK))

    def some(self, which: Any) -> _Nuclei:
        """Return some of them."""
        return replace(self, path=self.path[which], R_0=self.R_0[which], volume=self.volume[which])


def _marched(meshes: _Meshes, level: int, nuclei: _Nuclei) -> Array:
    """Return ``ln R/R_0`` and both masses of nuclei at the coarsest mesh's times, (3, k, nuclei).

    Implicit Euler in ``ln R``, in the vapor and in all shells. How large the bubble is to the
    shells, to its cell, to a tip and to surface tension is taken from the beginning of each step:
    what drives it then falls with ``R``, and a step has one answer.
    """
    melt, R_0 = nuclei.melt, nuclei.R_0
    shells = _Shells(nuclei)
    gas, V_0 = melt.gas, 4.0 / 3.0 * np.pi * R_0**3
    whole_0 = nuclei.volume / V_0
    most = np.maximum(np.log(whole_0 * FULL / (1.0 - FULL)) / 3.0, 0.0)
    grown, rate = np.zeros_like(R_0), np.zeros_like(R_0)
    ratio, cube, R, V = np.ones_like(R_0), np.ones_like(R_0), R_0, V_0
    mass = melt.vapor_pressure * V_0 / gas
    told = [(grown, mass, shells.mass())]
    paths, path = np.unique(nuclei.path, return_inverse=True)
    for k, of_all in enumerate(meshes.at(level, paths).steps(), 1):
        h, p, eta, gamma, fiber = (one[path] for one in of_all)
        if nuclei.tip is not None:
            p = p + fiber * nuclei.tip.share(R - R_0)
        supply, backlog = shells.outside_in(cube, h)
        # p_b V/gas = mass + h (supply - backlog p_b)
        amount, give = (mass + h * supply) * gas, h * backlog * gas
        step = _grown(
            (amount, V, give),
            p + 2.0 * melt.tension / R,
            _Resistance(melt.law, h, eta, gamma, cube / (cube + whole_0)),
            rate * h,
            (-grown, most - grown),
        )
        rate, grown = step / h, grown + step
        ratio = np.exp(grown)
        cube = ratio * ratio * ratio  # a power takes ten times as long
        R, V = R_0 * ratio, V_0 * cube
        p_b = amount / (V + give)
        mass = mass + h * (supply - backlog * p_b)
        shells.inside_out(p_b)
        if k % 2**level == 0:
            told.append((grown, mass, shells.mass()))
    return np.array(told).transpose(1, 0, 2)


class _Resistance:
    """What the melt's viscosity sets against growth by ``ln R``, in one step."""

    def __init__(
        self,
        law: ViscosityLaw | None,
        step: Array,
        viscosity: Array,
        flow_rate: Array,
        squeezed: Array,
    ) -> None:
        self._law, self._step, self._flow_rate, self._squeezed = law, step, flow_rate, squeezed
        self._factor = viscosity if law is None else viscosity / law.viscosity_at(flow_rate)

    def of(self, growth: Array) -> tuple[Array, Array]:
        """Return it [Pa] and its derivative by the growth."""
        if self._law is None:
            slope = 4.0 * self._factor * (1.0 - self._squeezed) / self._step
            return slope * growth, slope
        rate = growth / self._step
        T, slope = _resistance(rate, self._squeezed, self._law, self._flow_rate)
        return self._factor * T, self._factor * slope / self._step


def _grown(
    vapor: tuple[Array, Array, Array],
    outside: Array,
    resistance: _Resistance,
    before: Array,
    bounds: tuple[Array, Array],
) -> Array:
    """Return by how much ``ln R`` grows in a step: the root of ``p_b - outside - T``.

    Parameters
    ----------
    vapor : (amount, V, give)
        ``p_b = amount/(V exp(3 x) + give)``: it falls with growth ``x``.
    outside : array
        Pressure against it [Pa].
    resistance : _Resistance
        ``T``, which has the sign of ``x``.
    before : array
        By how much it would by its rate in the step before.
    bounds : (array, array)
        What it may shrink and grow to, 0 between: its crevice, and all of its cell.

    Raises
    ------
    ConvergenceError
        If Newton's method does not settle.
    """
    amount, V, give = vapor
    at_start = amount / (V + give)
    drive = at_start - outside
    sign = np.where(drive < 0.0, -1.0, 1.0)
    most = np.where(drive < 0.0, -bounds[0], bounds[1])
    drive = np.abs(drive)
    # T is concave: from below Newton's steps never go too far, from above they may go below zero.
    x = np.clip(sign * before, 0.0, most)
    for _ in range(MOST_STEPS):
        large = V * np.exp(3.0 * sign * x)
        p_b = amount / (large + give)
        T, slope = resistance.of(x)
        excess = T + sign * (at_start - p_b) - drive
        slope = slope + 3.0 * p_b * large / (large + give)
        new = x - excess / slope
        new = np.minimum(np.where(new < 0.0, x / 8.0, new), np.minimum(x + 1.0, most))
        change = np.abs(new - x)
        x = new
        if np.all(change <= SETTLED * x + STILL):
            return np.asarray(sign * x)
    msg = (
        f"the growth of a bubble was not found to {SETTLED:g} in {MOST_STEPS} of Newton's steps, "
        f"but to {np.max(change):.2g}: take a melt whose viscosity changes less with the rate"
    )
    raise ConvergenceError(msg)


class _Shells:
    """Water in the shells around bubbles, from the bubble outwards (shell, nuclei)."""

    def __init__(self, nuclei: _Nuclei) -> None:
        melt, R_0, count = nuclei.melt, nuclei.R_0, int(nuclei.shells[0])
        whole = 3.0 / (4.0 * np.pi) * nuclei.volume / R_0**3
        ratio = np.maximum((whole / FIRST) ** (1.0 / (count - 0.5)), SMALLEST_RATIO)
        shell = np.arange(count + 1.0)[:, None]
        # Cubes of radii over R_0 less the bubble's: of edges, and of where concentrations stand.
        edge = whole * (ratio**shell - 1.0) / (ratio**count - 1.0)
        place = edge / np.sqrt(ratio)
        self._volume = 4.0 / 3.0 * np.pi * R_0**3 * np.diff(edge, axis=0)
        self._place = place.astype(np.float32)
        conduct = 4.0 * np.pi * melt.diffusivity * R_0 / np.diff(place, axis=0)
        self._conduct = conduct.astype(np.float32)
        self._solubility = melt.solubility
        self._content = np.full_like(self._volume, melt.solubility * melt.vapor_pressure)
        self._offer, self._hold = np.empty_like(self._volume), np.empty_like(self._volume)

    def mass(self) -> Array:
        """Return the water in all of them [kg]."""
        return np.asarray(np.sum(self._content * self._volume, axis=0))

    def outside_in(self, cube: Array, step: Array) -> tuple[Array, Array]:
        """Return what reaches the bubble [kg/s], and what less for its pressure [kg/(s Pa)].

        Implicit Euler over a step [s], by elimination from the outermost shell: the content of a
        shell is ``offer + hold inner``, with that of the next one inside. What goes on outwards,
        ``flux (1 - hold)``, is summed by itself: it may be far below the flux.

        Parameters
        ----------
        cube : (nuclei) array
            ``(R/R_0)^3``.
        step : (nuclei) array
            How long it is [s].
        """
        flux = self._fluxes(cube)
        store = self._volume / step
        stored = store * self._content
        supply, beyond = np.zeros_like(cube), np.zeros_like(cube)
        for k in reversed(range(len(flux))):
            loose = store[k] + beyond
            part = 1.0 / (loose + flux[k])
            hold = np.multiply(flux[k], part, out=self._hold[k])
            stored[k] += supply
            np.multiply(stored[k], part, out=self._offer[k])
            supply = stored[k] * hold
            beyond = loose * hold
        return supply, beyond * self._solubility

    def _fluxes(self, cube: Array) -> Array:
        """Return the flux over a difference of content inside each shell [m3/s].

        ``4 pi D/(1/r - 1/r')``, steady between two spheres, by their cubes. In single precision, a
        tenth of the time: it is one number for both sides of the flux, so that no water is lost.
        """
        r = np.exp(np.log(cube.astype(np.float32) + self._place) / np.float32(3.0))
        low, high = r[:-1], r[1:]
        flux = self._conduct * low * high * (low * low + low * high + high * high)
        whole: Array = flux.astype(np.float64)
        return whole

    def inside_out(self, pressure: Array) -> None:
        """Put in what is left after the step, at the bubble's pressure [Pa] at its end."""
        inner = self._solubility * pressure
        for k in range(len(self._content)):
            inner = np.add(self._offer[k], self._hold[k] * inner, out=self._content[k])
