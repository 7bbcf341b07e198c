"""The orientation tensor along the flow and across the bead, and what its closure costs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, MultipleLocator

from fibermelt.parts.flow.figures.along import MARKS
from fibermelt.parts.flow.figures.carpet import weave
from fibermelt.parts.flow.figures.lines import Feature, features, line_word
from fibermelt.parts.flow.given import is_given
from fibermelt.parts.interaction.models import model_in_words
from fibermelt.parts.orientation.summary import stored_model
from fibermelt.report.kit.drawing import (
    draw_bead,
    draw_bed_motion,
    main_scene,
    mark_exit,
    paint,
    scene_axes,
)
from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.scene import MM, Window, read_scene
from fibermelt.report.kit.style import (
    BAND,
    BLUE,
    FULL,
    GREEN,
    GREY,
    INK,
    PINK,
    SEQUENTIAL,
    VERMILION,
    Array,
    Words,
    add_axes,
    color_bar,
    letter,
    new_figure,
)
from fibermelt.report.kit.tables import number, sized

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["angle_from", "component_along", "figure_across", "figure_tensor_history"]

CHARTS, SCALE = 62.0, 18.0
"""Height of the charts below the scene, and of the colour scale above the exit [mm]."""

COMPONENTS = (
    (0, "$a_{xx}$", VERMILION, "o"),
    (1, "$a_{yy}$", BLUE, "s"),
    (2, "$a_{zz}$", GREEN, "D"),
)
"""Components across the bead: number, name, colour and mark."""

TICK = 0.05
"""Longest tick over the width of the window: that of fibers that all lie alike."""

TICKED, APART = 11, 0.055
"""Streamlines with ticks at most, and how far ticks are apart over the window's width."""


def tensors(results: xr.Dataset) -> Array:
    """Return the orientation tensor along the streamlines, (streamline, point, 3, 3)."""
    order = ("streamline", "point", "axis", "other_axis")
    found: Array = results["orientation"].transpose(*order).to_numpy()
    return found


def component_along(results: xr.Dataset) -> Array:
    """Return ``s.a.s`` along the streamlines, ``s`` their direction, (streamline, point)."""
    velocity = np.stack([results[name].to_numpy() for name in "uv"], axis=-1)
    s = velocity / np.linalg.norm(velocity, axis=-1, keepdims=True)
    plane = tensors(results)[..., :2, :2]
    found: Array = np.einsum("...i,...ij,...j->...", s, plane, s)
    return found


def angle_from(a: Array) -> Array:
    """Return the preferred direction in the plane from the x axis [rad], (...).

    ``arctan2(2 a_xy, a_xx - a_yy)/2`` (the paper's Eq. 31), in (-pi/2, pi/2].
    """
    angle: Array = 0.5 * np.arctan2(2.0 * a[..., 0, 1], a[..., 0, 0] - a[..., 1, 1])
    return angle


def closure_row(results: xr.Dataset) -> int:
    """Return the row of the streamline along which the closure is judged."""
    number = int(results["closure_streamline"])
    return int(np.flatnonzero(results["streamline"].to_numpy() == number)[0])


def across_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    a = tensors(results)[:, -1]
    angle = np.degrees(angle_from(a))
    height = MM * results["y"].to_numpy()[:, -1]
    low, high = int(np.argmin(height)), int(np.argmax(height))
    lowest, highest = (sized(height[row], height[high]) for row in (low, high))
    ranges = ", ".join(
        f"a_{name}{name} {a[:, k, k].min():.2f} to {a[:, k, k].max():.2f}"
        for k, name in enumerate("xyz")
    )
    return Words(
        caption=(
            f"Orientation of the fibers: {_model(results)}. (a), (b) Component of the orientation "
            "tensor along the streamline; bars lie along the preferred direction in the plane and "
            "are as long as its two eigenvalues in the plane differ. (c) Diagonal of the tensor "
            "and (d) preferred direction from the bed's motion, counter-clockwise, at the outlet, "
            "one mark for each streamline; dotted: isotropic, and along the bed. Blank in the "
            "maps: beyond the outermost streamlines."
        ),
        alt=(
            "Two maps and two charts. Fibers line up with the flow on the way to the capillary "
            f"and turn with it onto the bed. In the finished bead the tensor has {ranges}. On the "
            f"lowest streamline, {lowest} mm high, a_xx is {a[low, 0, 0]:.2f} and the "
            f"preferred direction {angle[low]:.1f}°; on the highest, at {highest} mm, "
            f"{a[high, 0, 0]:.2f} and {angle[high]:.1f}°."
        ),
    )


def _model(results: xr.Dataset) -> str:
    """Return what was integrated."""
    text = (
        f"{model_in_words(*stored_model(results))}, closure {results['orientation_closure'].item()}"
    )
    if "orientation_convention" in results:
        text += f", {results['orientation_convention'].item()} convention"
    text += f", the error of the integration up to {float(results['orientation_error'].max()):.0e}"
    violation = float(results["orientation_violation"].max())
    if violation > 0.0:
        text += f"; eigenvalues leave [0, 1] by up to {violation:.1e}, as closures may"
    return text


@plate(
    "orientation",
    "Orientation across the bead",
    section="tensors",
    words=across_words,
    needs="orientation node_x",
    place=1,
)
def figure_across(results: xr.Dataset) -> Figure:
    """Draw the share of fibers along the streamlines, preferred directions, and the bead's end."""
    scene = read_scene(results)
    figure, axes, room = main_scene(scene, extra=SCALE, below=CHARTS)
    gap = scene_axes(figure, room.left, room.bottom, room.width, scene.exit)
    carpet, along, norm = weave(results), component_along(results), Normalize(0.0, 1.0)
    for panel, window in ((axes, scene.whole), (gap, scene.exit)):
        draw_bead(panel, scene, window)
        if carpet is not None:
            paint(panel, carpet.triangles, carpet.values(along), norm, SEQUENTIAL)
    _ticks(gap, results, scene.exit)
    draw_bed_motion(axes, results, scene)
    mark_exit(axes, gap, scene)
    letter(axes, "a  fibers along the streamlines", inside=True)
    letter(gap, "b  the same; bars: preferred directions (dashed frame)")
    top = room.bottom + room.fit(scene.exit)
    bar = add_axes(figure, room.left + 2, top + 15, room.width - 4, 2.5)
    label = "component of the tensor along the streamline; 1/3 isotropic, 1 aligned"
    color_bar(ScalarMappable(norm, SEQUENTIAL), bar, label)
    shares = add_axes(figure, 14, 10, 78, CHARTS - 23)
    turned = add_axes(figure, 109, 10, 78, CHARTS - 23)
    _shares(shares, results)
    _turned(turned, results)
    return figure


def _ticks(axes: Axes, results: xr.Dataset, window: Window) -> None:
    """Draw bars along the preferred direction, as long as the tensor is from isotropic."""
    a, wide = tensors(results), window.size[0]
    values, vectors = np.linalg.eigh(a[..., :2, :2])
    length = TICK * wide * (values[..., 1] - values[..., 0])
    half = 0.5 * length[..., None] * vectors[..., :, 1]
    place = MM * np.stack([results[name].to_numpy() for name in "xy"], axis=-1)
    count = len(place)
    bars = []
    for row in np.unique(np.linspace(0, count - 1, min(count, TICKED)).round().astype(int)):
        way = np.r_[0.0, np.cumsum(np.hypot(*np.diff(place[row], axis=0).T))]
        at = np.searchsorted(way, np.arange(0.5 * APART * wide, way[-1], APART * wide))
        bars += [(place[row, k] - half[row, k], place[row, k] + half[row, k]) for k in at]
    for color, linewidth in (("white", 1.6), (INK, 0.8)):
        axes.add_collection(
            LineCollection(bars, colors=color, linewidths=linewidth, zorder=2.5), autolim=False
        )


def _height(results: xr.Dataset) -> Array:
    """Return the height of each streamline at the outlet [mm], (streamline,)."""
    found: Array = MM * results["y"].to_numpy()[:, -1]
    return found


def _shares(axes: Axes, results: xr.Dataset) -> None:
    """Draw the tensor's diagonal at the outlet against the height."""
    a, height = tensors(results)[:, -1], _height(results)
    look: dict[str, Any] = {"linewidth": 1.2, "markersize": 3}
    for k, name, color, mark in COMPONENTS:
        axes.plot(a[:, k, k], height, color=color, marker=mark, label=name, **look)
    axes.axvline(1 / 3, color=GREY, linewidth=0.7, linestyle=(0, (1, 1.5)))
    axes.set_xlim(0.0, 1.0)
    axes.set_xlabel("component of the orientation tensor at the outlet")
    axes.legend(loc="lower left", bbox_to_anchor=(0.55, 1.02), ncols=3, columnspacing=1.2)
    letter(axes, "c  across the bead")
    _heights(axes, results)


def _turned(axes: Axes, results: xr.Dataset) -> None:
    """Draw the preferred direction at the outlet against the height."""
    angle = np.degrees(angle_from(tensors(results)[:, -1]))
    axes.plot(angle, _height(results), color=INK, marker="o", markersize=3, linewidth=1.2)
    axes.axvline(0.0, color=GREY, linewidth=0.7, linestyle=(0, (1, 1.5)))
    axes.margins(x=0.1)
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 1.5, 2, 3, 5, 10]))
    axes.set_xlabel("preferred direction from the bed's motion [°]")
    letter(axes, "d  its direction")
    _heights(axes, results)


def _heights(axes: Axes, results: xr.Dataset) -> None:
    axes.set_ylim(0.0, MM * float(results["downstream_surface"].to_numpy()[-1, 1]))
    axes.set_ylabel("height [mm]")
    axes.grid(axis="x", color=BAND, linewidth=0.4)


def history_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    along, word = component_along(results), line_word(results)
    told = "; ".join(
        f"on {word} {f.number} it reaches {along[f.row].max():.2f} and ends at "
        f"{along[f.row, -1]:.2f}"
        for f in features(results)
    )
    panels, follows = "Two", ""
    if "closure_error" in results:
        panels = "Three"
        error = float(results["closure_error"].max())
        follows = f" The closure follows the distribution to within {error:.3f}."
    marks = "; marks: zones" if "zone_time" in results else ""
    course = "rises on the way to the capillary and falls where the melt turns"
    if is_given(results):
        course = "over the whole way"
    return Words(
        caption=(
            f"Orientation along the marked {word}s: {_model(results)}. (a) Component along the "
            f"{word}, (b) along z; dotted: isotropic{marks}.{_judged(results)}"
        ),
        alt=(
            f"{panels} panels of curves over time. The component along the {word} {course}: "
            f"{told}.{follows}"
        ),
    )


def _judged(results: xr.Dataset) -> str:
    """Return what panel c shows, where the distribution is known."""
    if "closure_error" not in results:
        return ""
    row = closure_row(results)
    time, error = results["time"].to_numpy()[row], results["closure_error"].to_numpy()
    worst = int(np.argmax(error))
    return (
        f" (c) Along {line_word(results)} {int(results['closure_streamline'])}, the closure "
        "(coloured) and the distribution itself (dashed, Fokker-Planck, in error by up to "
        f"{float(results['closure_exact_error']):.0e}); filled: the largest difference of a "
        f"component, at most {error[worst]:.3f} at {number(time[worst], 3)} s and "
        f"{error[-1]:.3f} {'at its end' if is_given(results) else 'in the finished bead'}."
    )


@plate(
    "orientation-history",
    "Orientation along streamlines",
    section="tensors",
    words=history_words,
    needs="orientation",
    place=2,
)
def figure_tensor_history(results: xr.Dataset) -> Figure:
    """Draw the tensor along the marked streamlines in time, and the closure's error along one."""
    is_judged = "closure_error" in results
    bottoms = (104, 57, 10) if is_judged else (57, 10)
    figure = new_figure(FULL, bottoms[0] + 48)
    panels = [add_axes(figure, 13, bottom, 174, 38) for bottom in bottoms]
    first, second = panels[:2]
    marked = features(results)
    end = 1.03 * max(float(results["time"][f.row, -1]) for f in marked)
    _along(first, results, component_along(results))
    _along(second, results, tensors(results)[..., 2, 2])
    told = [
        (f"along the {line_word(results)}", f"a  component along the {line_word(results)}"),
        ("$a_{zz}$", "b  component across the plane of the flow"),
    ]
    if is_judged:
        _closures(panels[2], results)
        told.append(
            ("component", f"c  {line_word(results)} {_number(results)}: closure and distribution")
        )
    for axes, (name, text) in zip(panels, told, strict=True):
        axes.set_xlim(0.0, end)
        axes.set_ylim(0.0, 1.0)
        axes.yaxis.set_major_locator(MultipleLocator(0.25))
        axes.set_ylabel(name)
        axes.grid(axis="y", color=BAND, linewidth=0.4)
        letter(axes, text)
    for axes in panels[:-1]:
        axes.set_xticklabels([])
    panels[-1].set_xlabel("time since the inlet [s]")
    first.legend(loc="lower right", bbox_to_anchor=(1.0, 1.02), ncols=3, columnspacing=1.4)
    if is_judged:
        panels[2].legend(loc="lower right", bbox_to_anchor=(1.0, 1.02), ncols=5, columnspacing=1.4)
    return figure


def _number(results: xr.Dataset) -> int:
    return int(results["closure_streamline"])


def _along(axes: Axes, results: xr.Dataset, values: Array) -> None:
    """Draw values along the marked streamlines, with their zones."""
    for feature in features(results):
        time = results["time"].to_numpy()[feature.row]
        label = f"{line_word(results)} {feature.number}"
        axes.plot(time, values[feature.row], color=feature.color, linewidth=1.4, label=label)
        if "zone_time" in results:
            _zones(axes, results, feature, values[feature.row])
    axes.axhline(1 / 3, color=GREY, linewidth=0.7, linestyle=(0, (1, 1.5)))


def _zones(axes: Axes, results: xr.Dataset, feature: Feature, values: Array) -> None:
    time, zones = (results[n].to_numpy()[feature.row] for n in ("time", "zone_time"))
    for when, zone in zip(zones, results["zone"].to_numpy(), strict=True):
        value = np.interp(when, time, values)
        axes.plot(
            when, value, MARKS[zone - 1], mfc="white", mec=feature.color, markersize=4.5, zorder=3
        )


def _closures(axes: Axes, results: xr.Dataset) -> None:
    """Draw components of the closure and of the distribution, and the largest difference."""
    row = closure_row(results)
    time, a = results["time"].to_numpy()[row], tensors(results)[row]
    exact = results["closure_exact"].transpose("point", "axis", "other_axis").to_numpy()
    for k, name, color, _ in COMPONENTS:
        axes.plot(time, a[:, k, k], color=color, linewidth=1.4, label=name)
        axes.plot(time, exact[:, k, k], color=INK, linewidth=0.8, linestyle=(0, (3, 2)))
    axes.plot([], [], color=INK, linewidth=0.8, linestyle=(0, (3, 2)), label="distribution")
    error = results["closure_error"].to_numpy()
    axes.fill_between(time, 0.0, error, color=PINK, linewidth=0, label="largest difference")
