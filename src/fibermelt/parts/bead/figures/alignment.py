"""The fibers' angle to the streamline at the three zones (the paper's Fig. 20)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from fibermelt.parts.bead.figures.spread import by_streamline, draw_fibers, draw_mean, spread_key
from fibermelt.parts.flow.figures.lines import ZONES, at_corners, initial_angles, line_word, regular
from fibermelt.parts.flow.given import is_given
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.style import (
    BAND,
    FULL,
    Array,
    Words,
    add_axes,
    key_above,
    letter,
    new_figure,
)

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_alignment", "isotropic_angles", "within_quarter_turn"]

STARTS = 3600
"""Evenly spread starts that stand for all: a twentieth of a degree apart."""

SHARES = ((0.9, BAND, 0.9), (0.5, "#6b7f92", 0.7))
"""Shares of all starts that the bands hold, their colour and opacity."""

DISTINCT = 1e-6
"""Directions are told apart beyond this [rad]; three determine the map of all."""


def within_quarter_turn(angle: Array) -> Array:
    """Return angles within a quarter turn of their mean direction [rad], along the last axis.

    A fiber has no head; its mean direction is ``arg(mean exp(2 i theta))/2``.
    """
    mean = 0.5 * np.angle(np.exp(2j * angle).mean(axis=-1, keepdims=True))
    near: Array = mean + 0.5 * np.angle(np.exp(2j * (angle - mean)))
    return near


def isotropic_angles(start: Array, found: Array) -> Array | None:
    """Return the angles at which fibers of evenly spread starts are found [rad], (..., `STARTS`).

    Directions in the plane are mapped as ``p ~ F p_0``, one matrix ``F`` for all of them, so that
    three of them determine it: ``p x F p_0 = 0`` is solved for ``F`` up to its size, by singular
    values. Of directions in space this holds for the angle seen along z.

    Parameters
    ----------
    start : (n,) array
        Initial angles [rad].
    found : (..., n) array
        The angles of the same fibers later [rad], each relative to one direction for all.

    Returns
    -------
    array or None
        None if fewer than three initial directions differ.
    """
    apart = np.abs(np.sin(start[:, None] - start))
    first = [k for k in range(len(start)) if not np.any(apart[k, :k] < DISTINCT)]
    if len(first) < 3:
        return None
    p0 = np.stack([np.cos(start), np.sin(start)], axis=-1)
    p = np.stack([np.cos(found), np.sin(found)], axis=-1)
    rows = np.concatenate([p[..., 1:] * p0, -p[..., :1] * p0], axis=-1)
    F = np.linalg.svd(rows)[2][..., -1, :].reshape(*found.shape[:-1], 2, 2)
    even = np.pi * (np.arange(STARTS) + 0.5) / STARTS
    x, y = np.einsum("...ij,jk->i...k", F, np.stack([np.cos(even), np.sin(even)]))
    return np.asarray(np.arctan2(y, x))


def _zone_angles(results: xr.Dataset) -> dict[int, Array]:
    """Return the angles to the streamline by zone [rad], (streamline, initial_angle) each.

    NaN on paths that end before it.
    """
    angle = results["zone_angle"].transpose("zone", "streamline", "initial_angle").to_numpy()
    return dict(zip(results["zone"].to_numpy().tolist(), within_quarter_turn(angle), strict=True))


def alignment_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    word, told = line_word(results), []
    angles = _zone_angles(results)
    for zone, angle in angles.items():
        away = np.degrees(np.abs(angle))
        half = np.median(away, axis=1)
        steady = regular(results) & np.isfinite(half)
        if not steady.any():
            continue
        calm = int(np.argmax(np.where(steady, half, -1.0)))
        told.append(
            f"at zone {zone} half of them within {half[steady].min():.0f}° to "
            f"{half[calm]:.0f}°, the latter on {word} {int(results['streamline'][calm])}"
        )
    near = at_corners(results, f"Diamonds: {word}s", ", near a sharp corner.")
    zones = (
        "zones 1 to 3" if len(angles) == len(ZONES) else f"zone {' and '.join(map(str, angles))}"
    )
    opening = "Angle" if is_given(results) else "Fig. 20 of the paper: angle"
    return Words(
        caption=(
            f"{opening} of the fibers to the {word} at {zones}, by "
            f"{word}, for fibers of {initial_angles(results)} (points; line: their mean). "
            "Bounds over all initial angles would be the whole half turn, as every direction is "
            "that of some start; the bands hold the middle shares of evenly spread starts, exact "
            f"by the one linear map that all directions of a {word} share.{near}"
        ),
        alt=(
            f"Charts by {word} of the fibers' angles to it at {zones}, either way: "
            f"{'; '.join(told)}."
        ),
    )


@plate(
    "alignment",
    "Orientation at the zones",
    section="fibers",
    words=alignment_words,
    needs="zone_angle",
    paper="Fig. 20",
)
def figure_alignment(results: xr.Dataset) -> Figure:
    """Draw the angle to the streamline by streamline, at the zones."""
    figure = new_figure(FULL, 82)
    number, start = results["streamline"].to_numpy(), results["initial_angle"].to_numpy()
    angles = _zone_angles(results)
    most = 30.0 * float(
        np.ceil(max(np.degrees(np.nanmax(np.abs(a))) for a in angles.values()) / 30.0)
    )
    for k, (zone, angle) in enumerate(angles.items()):
        axes = add_axes(figure, 13 + 60 * k, 9, 55, 62)
        everywhere = isotropic_angles(start, angle)
        if everywhere is not None:
            near = np.degrees(within_quarter_turn(everywhere))
            for share, color, opacity in SHARES:
                ends = np.quantile(near, [0.5 - 0.5 * share, 0.5 + 0.5 * share], axis=-1)
                axes.fill_between(number, *ends, color=color, alpha=opacity, lw=0, zorder=1)
        axes.set_ylim(-1.03 * most, 1.03 * most)
        axes.set_yticks(np.arange(-most, most + 1.0, 30.0))
        draw_fibers(axes, results, np.degrees(angle))
        draw_mean(axes, results, np.degrees(angle.mean(axis=1)))
        by_streamline(axes, results)
        letter(axes, f"{'abc'[k]}  zone {zone}, {ZONES[zone - 1]}")
        if k == 0:
            axes.set_ylabel(f"angle to the {line_word(results)} [°]")
            key_above(axes, _key(results), 1.085, columns=5, between=1.4)
        else:
            axes.tick_params(labelleft=False)
    return figure


def _key(results: xr.Dataset) -> list[Line2D | Patch]:
    """Return what line, points and bands mean."""
    mean, _, fibers, _, _, near = spread_key(results)
    bands = [
        Patch(facecolor=color, alpha=opacity, label=f"{100 * share:.0f} % of all starts")
        for share, color, opacity in SHARES
    ]
    return [mean, fibers, *bands, near]
