"""A spheroid in the plane of a planar flow of a thinning melt, from the shipped table.

The answers of a spheroid in an unbounded power-law melt depend on its aspect ratio ``r_e``, the
index ``n`` and the direction ``phi`` of the strain in its axes, and on nothing else
(`fibermelt.fiber.thinning`). ``data/thinning_spheroid.csv`` holds them, solved in three dimensions
by `fibermelt.fiber.cell.spheroid_table`. Between its points (``n = 1`` is the closed form of
`unbounded_spheroid`, exactly, as what is interpolated is the difference or the ratio to it):

    omega(n) = xi sin phi + [omega(n) - omega(1)],    l(n) = l(closed form) [l(n)/l(1)],

the brackets from the same elements, so that much of their error cancels; in ``ln r_e`` a cubic
spline, in ``n`` the polynomial through all, in ``phi`` sines for the spin and a cubic for extremes.

A melt that is no power law is taken as the one of the same viscosity at the far field's rate and at
the rate ``k`` times as high that the fiber's own flow has where the pressure arises (`tip_rate`):

    n = 1 + ln(eta(k gamma_dot)/eta(gamma_dot))/ln k,      stresses over eta(gamma_dot) d.

`LOCAL_INDEX_ERROR` has what that is worth; `fibermelt.fiber.solve_thinning_spheroid` solves for the
law itself.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from fibermelt.errors import ConfigError, refuse_other
from fibermelt.fiber.curve import fold_angle
from fibermelt.fiber.spheroid import Spheroid, unbounded_spheroid
from fibermelt.fiber.thinning import (
    KNOTS,
    ThinningResponse,
    odd_cosines,
    odd_sines,
    table_rates,
)
from fibermelt.melt import PowerLaw, ViscosityLaw

__all__ = [
    "COLUMNS",
    "LOCAL_INDEX_ERROR",
    "SpheroidTable",
    "spheroid_table",
    "unbounded_thinning_spheroid",
]

Array = NDArray[np.float64]
Axes = tuple[Array, Array, Array]

COLUMNS = (
    "aspect_ratio",
    "phase",
    "index",
    "spin",
    "lowest",
    "highest",
    "tip",
    "lowest_in_plane",
    "highest_in_plane",
    "angle_lowest",
    "azimuth_lowest",
    "angle_highest",
    "azimuth_highest",
    "angle_lowest_in_plane",
    "angle_highest_in_plane",
)
"""Of the table: angles in degrees, the spin over ``d``, pressures over ``eta d``. A place is an
eccentric angle from the tip and an azimuth from the flow's plane, in the plane a signed angle."""

PHASE = 2
"""Axis of the phases in a table."""

FILE = "thinning_spheroid.csv"

RATES_PER_DECADE = 8
"""Rates at which a law that bends is read; linear or cubic between, as laws bend over decades."""

LEFT_OUT = 1.0 / 8.0
"""What the error of the interpolation is of the error at a point of the table that was left out: a
cubic's falls to a sixteenth when its spacing is halved, with corners between by an order less."""

TIP_SHARE = 2.0 / 3.0
"""Share of the highest shear rate on the fiber that a melt's index is taken up to. Measured: the
lowest pressures that a Cross and a Carreau melt gave in a stretch, at six rates, are those of the
indices up to 0.70 of it for ``r_e = 6`` and up to 0.63 for ``r_e = 20``."""

SPIN_TERMS = 8
"""Sines of the spin, whose index depends on the direction."""

LOCAL_INDEX_ERROR = (0.006, 0.022)
"""What the spin, and extremes over the largest pressure, of a melt that is no power law may be off:
the most by which 19 solutions of a Cross (index 0.27) and a Carreau melt (0.35) at and around their
bends differed from it, ``r_e`` 2.5, 6 and 20, ``phi`` 0, 60 and 90 degrees. With the slope of the
law at the far field's rate alone the lowest pressure was off by 0.3 (``r_e`` = 6) and 1.1 (20)."""

ROUNDING = 1e-9
"""What an index may be above one, or an aspect ratio beyond the table's ends."""


@dataclass(frozen=True, eq=False)
class SpheroidTable:
    """Answers of spheroids in power-law melts, as they were solved for.

    Parameters
    ----------
    index, aspect_ratio, phase : (n,), (r,), (f,) array
        Indices, the last one 1, and aspect ratios [-]; ``phi`` in [0, pi/2] [rad]; all increasing.
    values : dict of (n, r, f) arrays
        The columns from ``spin`` on.
    """

    index: Array
    aspect_ratio: Array
    phase: Array
    values: dict[str, Array]

    def change(self, name: str, index: Array, aspect_ratio: float, phase: Array) -> Array:
        """Return what thinning does at phases (k,) [rad], for each its indices (m, k), (m, k).

        Parameters
        ----------
        name : {"spin", "lowest", "highest", "tip"}
            The difference of the spin and of the tip's pressure, over that of ``phi = 0``, to those
            of ``n = 1``; the logarithm of the ratio of an extreme to that of ``n = 1``.
        index, aspect_ratio, phase
            Where, within the table.
        """
        axes = self.index, np.log(self.aspect_ratio), self.phase
        along = _along(name, axes, _change(name, self.values), np.log(aspect_ratio), phase)
        return np.asarray(np.einsum("mkn,nk->mk", _lagrange(self.index, index), along))

    @cached_property
    def errors(self) -> dict[str, Array]:
        """Return the estimated errors near each point of the table, (n, r, f).

        That of ``spin`` [-]; those of ``lowest`` and ``highest`` over the largest pressure of their
        index and aspect ratio. Two parts. The elements': what the closed form is missed by at ``n =
        1``, or, if that is more, what a sphere's answers in one melt differ by, which are the same
        in every direction: its spin is none, its extremes are opposite. The interpolation's: for
        each axis `LEFT_OUT` of what a point is missed by when it is left out (at the ends that of
        the neighbour). None at ``n = 1``, the closed form.
        """
        axes = self.index, np.log(self.aspect_ratio), self.phase
        sphere = np.stack([-self.values["lowest"][:, 0], self.values["highest"][:, 0]])
        uneven = 0.5 * np.ptp(sphere, axis=(0, 2)) / np.mean(sphere, axis=(0, 2))
        turning = np.max(np.abs(self.values["spin"][:, 0]), axis=1)
        largest = np.maximum(-self.values["lowest"], self.values["highest"]).max(axis=2)
        exact = [_newtonian(Spheroid(1.0, ratio), self.phase) for ratio in self.aspect_ratio]
        found = {}
        for name in ("spin", "lowest", "highest"):
            value, change = self.values[name], _change(name, self.values)
            closed = np.stack([getattr(one, name) for one in exact])
            spin = name == "spin"
            scale = np.ones(1) if spin else np.abs(value) / largest[..., None]
            gap = np.abs(value[-1] - closed) / (1.0 if spin else np.abs(closed))
            elements = np.maximum(gap, (turning if spin else uneven)[:, None, None])
            between = sum(_missed(name, axes, change, axis) for axis in range(3))
            found[name] = scale * (elements + LEFT_OUT * between)
            found[name][-1] = 0.0
        return found


@dataclass(frozen=True, eq=False)
class _Newtonian:
    """The closed form at phases (k,): spin, pressures over ``eta d``, eccentric angles [rad]."""

    spin: Array
    lowest: Array
    highest: Array
    tip: Array
    where_lowest: Array
    where_highest: Array


def _newtonian(fiber: Spheroid, phase: Array) -> _Newtonian:
    strain = np.zeros((phase.size, 3, 3))
    strain[:, 0, 0], strain[:, 0, 1] = np.cos(phase), np.sin(phase)
    strain[:, 1, 0], strain[:, 1, 1] = np.sin(phase), -np.cos(phase)
    exact, along = unbounded_spheroid(fiber), [1.0, 0.0, 0.0]
    ends = exact.extremes(strain, along)
    places = (
        fold_angle(np.arctan2(e[:, 1], e[:, 0])) for e in (ends.where_lowest, ends.where_highest)
    )
    spin = exact.shape_factor * np.sin(phase)
    return _Newtonian(spin, ends.lowest, ends.highest, exact.tip(strain, along), *places)


@cache
def spheroid_table() -> SpheroidTable:
    """Return the table that is shipped."""
    text = files("fibermelt.data").joinpath(FILE).read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    rows = np.array([[float(row[name]) for name in COLUMNS] for row in csv.DictReader(lines)])
    ratio, phase, index = (np.unique(rows[:, k]) for k in range(3))
    shape = index.size, ratio.size, phase.size
    rows = rows[np.lexsort((rows[:, 1], rows[:, 0], rows[:, 2]))]
    values = {name: rows[:, k].reshape(shape) for k, name in enumerate(COLUMNS) if k > 2}
    return SpheroidTable(index, ratio, np.radians(phase), values)


def unbounded_thinning_spheroid(
    fiber: Spheroid, law: ViscosityLaw, rates: tuple[float, float] | None = None
) -> ThinningResponse:
    """Return the answers of a spheroid in the plane of planar flows of an unbounded thinning melt.

    What takes a `ThinningResponse` takes it: `follow`, `surface_pressure`, `pressure_bounds`,
    `isotropic_pressure`, `orbit`.

    Parameters
    ----------
    fiber : Spheroid
        Of an aspect ratio within the table, 1 to 20.
    law : ViscosityLaw
        The melt, of an index within the table, 0.25 to 1, at the rates that are asked for.
    rates : (2,) tuple of float, optional
        Lowest and highest ``gamma_dot`` [1/s] that will be asked for; all if not given.

    Returns
    -------
    ThinningResponse
        Its errors are those of the table at the worst of its points next to what is read, and for
        a melt that is no power law `LOCAL_INDEX_ERROR` beside them. Places are those in the
        flow's plane.

    Raises
    ------
    ConfigError
        If aspect ratio or index lie outside of the table.
    """
    refuse_other("fiber", fiber, Spheroid)
    refuse_other("law", law, ViscosityLaw)
    table, ratio = spheroid_table(), fiber.aspect_ratio
    if not table.aspect_ratio[0] <= ratio <= table.aspect_ratio[-1] * (1 + ROUNDING):
        msg = (
            f"fiber.aspect_ratio = {ratio:g}: the table of spheroids in thinning melts has "
            f"{table.aspect_ratio[0]:g} to {table.aspect_ratio[-1]:g}; solve_thinning_spheroid "
            "solves for one strain"
        )
        raise ConfigError(msg)
    fine = np.linspace(0.0, 0.5 * np.pi, KNOTS + 1)
    exact = _newtonian(fiber, fine)
    reach = tip_rate(exact.lowest, exact.highest)
    rate = table_rates(law, rates, RATES_PER_DECADE, float(reach.max()))
    index = _indices(law, rate, reach, table)
    low, high, end = (
        table.change(name, index, ratio, fine) for name in ("lowest", "highest", "tip")
    )
    terms = slice(None, None, KNOTS // SPIN_TERMS)
    turned = table.change("spin", index, ratio, fine) + exact.spin
    places = [
        _places(table, f"angle_{name}_in_plane", index, ratio, getattr(exact, f"where_{name}"))
        for name in ("lowest", "highest")
    ]
    turn, worst = _errors(table, index, ratio)
    local = LOCAL_INDEX_ERROR if rate.size > 1 else (0.0, 0.0)
    return ThinningResponse(
        aspect_ratio=ratio,
        law=law,
        rate=rate,
        spin=odd_sines(turned[:, terms]),
        lowest=exact.lowest * np.exp(low),
        highest=exact.highest * np.exp(high),
        where_lowest=places[0],
        where_highest=places[1],
        tip=exact.tip + exact.tip[0] * end,
        surface=np.zeros(0),
        pressure=np.zeros((rate.size, 0, 0)),
        spin_error=turn + local[0],
        pressure_error=worst + local[1],
    )


def tip_rate(lowest: Array, highest: Array) -> Array:
    """Return ``k`` from the extremes over ``eta d`` [-] of a Newtonian melt.

    The traction on the surface is ``Sigma n``, its part along the surface at most half the
    difference of the outer eigenvalues of ``Sigma``, so half that of the extreme pressures: the
    highest shear rate on the fiber. `TIP_SHARE` of it, over ``gamma_dot = 2 d``.
    """
    return np.asarray(TIP_SHARE * 0.25 * (highest - lowest))


def _indices(law: ViscosityLaw, rate: Array, reach: Array, table: SpheroidTable) -> Array:
    """Return the indices at rates (m,) [1/s], reaches (k,): (m, k); or refuse (`ConfigError`)."""
    if isinstance(law, PowerLaw):
        index = np.full((1, reach.size), law.index)
    else:
        fall = law.viscosity_at(np.outer(rate, reach)) / law.viscosity_at(rate)[:, None]
        index = 1.0 + np.log(fall) / np.log(reach)
    low, high = table.index[[0, -1]]
    outside = np.argwhere((index < low - ROUNDING) | (index > high + ROUNDING))
    if outside.size:
        row, column = outside[0]
        between = f"{rate[row]:.3g} to {rate[row] * reach[column]:.3g} 1/s"
        msg = (
            f"melt: its index from {between} is {index[row, column]:.3g}: the table of spheroids "
            f"in thinning melts has {low:g} to {high:g}; give rates = (lowest, highest) that "
            "keep to it, or take solve_thinning_spheroid for one strain"
        )
        raise ConfigError(msg)
    return np.asarray(np.clip(index, low, high))


def _errors(table: SpheroidTable, index: Array, aspect_ratio: float) -> tuple[float, float]:
    """Return the errors of spin and pressure, the largest next to what is read."""
    rows = _around(table.index, float(index.min()), float(index.max()))
    columns = _around(table.aspect_ratio, aspect_ratio, aspect_ratio)
    worst = {name: float(np.max(part[rows, columns])) for name, part in table.errors.items()}
    return worst["spin"], max(worst["lowest"], worst["highest"])


def _around(knots: Array, low: float, high: float) -> slice:
    """Return the knots from the last not above ``low`` to the first not below ``high``."""
    first = np.searchsorted(knots, low, side="right") - 1
    return slice(max(int(first), 0), int(np.searchsorted(knots, high * (1 - ROUNDING))) + 1)


def _places(
    table: SpheroidTable, name: str, index: Array, aspect_ratio: float, exact: Array
) -> Array:
    """Return eccentric angles [rad] in the plane, (m, KNOTS + 1), those of the nearest points.

    Between aspect ratios the angle of the normal, ``arctan(r_e tan nu)``, is what hardly changes.
    """
    fine = np.linspace(0.0, 0.5 * np.pi, exact.shape[0])
    near = np.abs(table.phase - fine[:, None]).argmin(axis=1)
    rows = np.abs(table.index - index[..., None]).argmin(axis=-1)
    column = np.abs(np.log(table.aspect_ratio / aspect_ratio)).argmin()
    angle = fold_angle(np.radians(table.values[name][rows, column, near]))
    angle = np.arctan2(table.aspect_ratio[column] * np.sin(angle), aspect_ratio * np.cos(angle))
    return np.where(rows == table.index.size - 1, exact, angle)


def _change(name: str, values: dict[str, Array]) -> Array:
    """Return `SpheroidTable.change` at the points of a table, (n, r, f)."""
    part = values[name]
    if name in ("lowest", "highest"):
        return np.asarray(np.log(part / part[-1]))
    change = part - part[-1]
    return np.asarray(change / part[-1, :, :1] if name == "tip" else change)


def _along(name: str, axes: Axes, values: Array, ratio: ArrayLike, phase: Array) -> Array:
    """Return values (n, r, f) at other ``ln r_e`` and phases (k,), (n, ..., k)."""
    along = CubicSpline(axes[1], values, axis=1)(ratio)
    if name in ("lowest", "highest"):
        return np.asarray(CubicSpline(axes[2], along, axis=-1)(phase))
    # by symmetry odd multiples of the angle: sines from 0 on, cosines to pi/2
    wave = np.outer(2 * np.arange(axes[2].size - 1) + 1, phase)
    if name == "spin":
        return np.asarray(odd_sines(along) @ np.sin(wave))
    return np.asarray(odd_cosines(along) @ np.cos(wave))


def _lagrange(knots: Array, at: Array) -> Array:
    """Return the weights (..., n) of the values at knots in the polynomial through them."""
    gaps = at[..., None] - knots
    weights = np.ones((*at.shape, knots.size))
    for k, knot in enumerate(knots):
        rest = np.delete(np.arange(knots.size), k)
        weights[..., k] = np.prod(gaps[..., rest] / (knot - knots[rest]), axis=-1)
    return weights


def _missed(name: str, axes: Axes, values: Array, axis: int) -> Array:
    """Return what the points of a table are missed by when they are left out along an axis.

    One at a time; every second phase, whose series need equal spaces. Where none is left out, what
    its neighbours are missed by.
    """
    count, parts = values.shape[axis], []
    lots = [np.arange(1, count, 2)] if axis == PHASE else np.arange(1, count - 1)[:, None]
    for lot in lots:
        rest = tuple(np.delete(one, lot) if k == axis else one for k, one in enumerate(axes))
        at = tuple(one[lot] if k == axis else one for k, one in enumerate(axes))
        left = np.delete(values, lot, axis=axis)
        along = _along(name, (rest[0], rest[1], rest[2]), left, at[1], at[2])
        found = np.einsum("mn,n...->m...", _lagrange(rest[0], at[0]), along)
        parts.append(np.abs(found - np.take(values, lot, axis=axis)))
    missed = np.concatenate(parts, axis=axis)
    places = np.concatenate(lots)
    near = np.abs(np.arange(count)[:, None] - places)
    # of two neighbours the one that is missed by more
    either = [np.take(missed, pick, axis=axis) for pick in (near.argmin(axis=1), _last_least(near))]
    return np.asarray(np.maximum(*either))


def _last_least(values: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the last place of the least of each row."""
    return np.asarray(values.shape[1] - 1 - values[:, ::-1].argmin(axis=1))
