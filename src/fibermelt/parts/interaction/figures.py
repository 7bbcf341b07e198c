"""From fiber content to the size of the cell (the paper's Fig. 14 and 15), its fits beside."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MultipleLocator

from fibermelt.report.kit.plates import plate
from fibermelt.report.kit.style import (
    BAND,
    BLUE,
    COLUMN,
    FULL,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PINK,
    VERMILION,
    Words,
    add_axes,
    letter,
    new_figure,
    shades,
)
from fibermelt.units import DEGREES

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["figure_interaction", "figure_sizes"]

PAPER_RATIO = 6.0
"""Aspect ratio of the paper's polynomials."""

LOOKS: dict[str, dict[str, Any]] = {
    "ORE": {"color": VERMILION},
    "ORF": {"color": ORANGE},
    "ORW3": {"color": BLUE, "linestyle": (0, (2, 4)), "zorder": 3},
    "IBOF": {"color": GREEN, "linestyle": (2, (2, 4)), "zorder": 3},
    "exact": {"color": INK, "linestyle": (4, (2, 4)), "zorder": 3},
    "quadratic": {"color": PINK},
    "hybrid": {"color": GREY},
    "exact-pdf": {"color": INK, "linewidth": 1.4},
}
"""Dashes of three closures lie in one another's gaps: they all but coincide."""

NAMES = {"exact-pdf": "distribution", "exact": "exact closure"}
"""What the results call otherwise."""

BOLD, FINE = 2.4, 1.0
"""Widths of the line of the study's closure and of the others [pt]."""

PAPER: dict[str, Any] = {"color": INK, "linewidth": 0.9, "linestyle": (0, (4, 2)), "zorder": 4}
"""How the paper's polynomials are drawn."""

CONVENTIONS = {"standard": VERMILION, "paper": BLUE}

STRETCHED: dict[str, Any] = {
    "linestyle": (0, (6, 1.5, 1.5, 1.5)),
    "linewidth": 1.5,
    "dash_capstyle": "butt",
}
"""The paper's convention where a line's colour tells the closure."""

LEFT, WIDTH, KEY = (13.0, 92.0), 60.0, 156.0
"""Left sides of the panels, their width, and the left side of the keys beside them [mm]."""

ROWS, HEIGHT = (73.0, 10.0), 47.0
"""Lower sides of the panels and their height [mm]."""


def interaction_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    largest = float(results["largest_stalling_domain"])
    closure = str(results["interaction_closure"].item())
    sizes = results["stalling_domain_size"].to_numpy()
    last = np.degrees(results["stalling_angle"].to_numpy()[:, -1])
    apart = " and ".join(
        f"{_angle(value)} in the {name} convention"
        for name, value in _by_convention(results, "interaction_angle_difference")
    )
    interaction = results["interaction"].to_numpy()
    first, end = float(interaction[0]), float(interaction[-1])
    return Words(
        caption=(
            f"{_fibers(results)} (a) Angle and (b) spin of a fiber that starts across a simple "
            "shear of 1/s, in cells in which it stalls. (c) Stall angle against the size of the "
            f"cell, from {int(np.isfinite(results['stall_domain_size']).sum())} cells and the "
            f"unbounded melt; in cells above M = {largest:.4f} it tumbles. The paper's Eq. 32 "
            f"differs by up to {_angle(float(results['stall_curve_difference']))}, from M = 3 on. "
            "(d) Preferred angle of a suspension in simple shear: closures of the fourth moment "
            f"({closure}, wide, is the study's) and the distribution itself, with the rate of "
            "deformation of the standard convention; dash-dotted with the paper's, which is "
            f"sqrt(2) times as large. The paper's Eq. 33 differs from {closure} by up to "
            f"{apart}.{_missing(results)}"
        ),
        alt=(
            "Four panels. Fibers fall from across the flow and come to rest, the later the larger "
            f"the cell: after {float(results['stalling_time'][-1]):g} s at {last[0]:.1f}° to the "
            f"flow in a cell of M = {sizes[0]:.2f} and {last[-1]:.1f}° at {sizes[-1]:.2f}. The "
            "stall angle falls with the size of the cell, ever more steeply, to none at "
            f"{largest:.2f}. The preferred angle grows with the interaction coefficient, "
            f"{_grows(results, closure, first, end)}."
        ),
    )


@plate(
    "interaction",
    "Where fibers stall and how suspensions lie",
    section="content",
    words=interaction_words,
    needs="interaction_angle",
    paper="Fig. 14",
)
def figure_interaction(results: xr.Dataset) -> Figure:
    """Draw how fibers come to rest, where, and how fibers lie in a suspension (Fig. 14a-d)."""
    figure = new_figure(FULL, 127)
    (angle, spin), (stall, preferred) = (
        [add_axes(figure, left, bottom, WIDTH, HEIGHT) for left in LEFT] for bottom in ROWS
    )
    _rests(results, angle, spin)
    _stalls(results, stall)
    _preferred(results, preferred)
    for bottom, handles in ((ROWS[0], _sizes_key(results)), (ROWS[1], _closures_key(results))):
        key = add_axes(figure, KEY, bottom, FULL - KEY - 1, HEIGHT)
        key.set_axis_off()
        key.legend(handles=handles, loc="upper left", handlelength=2.2, labelspacing=0.5)
    return figure


def _fibers(results: xr.Dataset) -> str:
    """Return whose curves these are, and that the paper's are of others if they are."""
    ratio = float(results["stall_aspect_ratio"])
    if ratio == PAPER_RATIO:
        return f"Fibers of aspect ratio {ratio:g}."
    return (
        f"Fibers of aspect ratio {ratio:g}; the paper's polynomials are of {PAPER_RATIO:g}, and "
        "differ for that alone."
    )


def _angle(radians: float) -> str:
    """Return an angle in both units, or that there is none."""
    if np.isnan(radians):
        return "nowhere to compare with"
    return f"{radians:.4f} rad ({np.degrees(radians):.2f}°)"


def _by_convention(results: xr.Dataset, name: str) -> list[tuple[str, float]]:
    values = results[name].to_numpy()
    return [(str(c), float(v)) for c, v in zip(results["convention"].values, values, strict=True)]


def _missing(results: xr.Dataset) -> str:
    """Return which curves have gaps, if any."""
    angle = results["interaction_angle"].sel(convention="standard")
    gaps = [str(c) for c in results["closure"].values if np.isnan(angle.sel(closure=c)).any()]
    return f" Not everywhere with a steady state: {', '.join(gaps)}." if gaps else ""


def _grows(results: xr.Dataset, closure: str, first: float, end: float) -> str:
    """Return from where to where the preferred angle grows."""
    known = [str(name) for name in results["closure"].values]
    shown = closure if closure in known else known[-1]
    angle = results["interaction_angle"].sel(convention="standard", closure=shown).to_numpy()
    here = np.degrees(angle[np.isfinite(angle)])
    if here.size == 0:
        return f"but for {shown}, which has no steady state"
    return (
        f"between C_I of {first:.3f} and {end:.3f} from {here[0]:.1f}° to {here[-1]:.1f}° with "
        f"{'the distribution' if shown == 'exact-pdf' else shown}"
    )


def _grid(axes: Axes) -> None:
    axes.grid(axis="y", color=BAND, linewidth=0.4)


def _rests(results: xr.Dataset, upper: Axes, lower: Axes) -> None:
    """Draw angle and spin of fibers that come to rest, from across the flow."""
    time = results["stalling_time"].to_numpy()
    colors = shades(results.sizes["stalling_size"])
    for axes, name, scale in (
        (upper, "stalling_angle", DEGREES),
        (lower, "stalling_spin", 1.0),
    ):
        for row, color in zip(results[name].to_numpy(), colors, strict=True):
            axes.plot(time, scale * row, color=color, linewidth=1.2)
        axes.set_xlim(0.0, float(time[-1]))
        axes.xaxis.set_major_locator(MultipleLocator(0.25 * float(time[-1])))
        axes.set_xlabel("time [s] at a shear rate of 1/s")
        _grid(axes)
    upper.set_ylim(0.0, 90.0)
    upper.yaxis.set_major_locator(MultipleLocator(30.0))
    upper.set_ylabel(r"angle $\theta$ from the flow [°]")
    lower.set_ylabel(r"spin $\dot\theta$ [1/s]")
    letter(upper, "a  angle until the fiber rests")
    letter(lower, "b  spin")


def _sizes_key(results: xr.Dataset) -> list[Line2D]:
    sizes = results["stalling_domain_size"].to_numpy()
    return [
        Line2D([], [], color=color, linewidth=1.2, label=f"M = {size:.2f}")
        for size, color in zip(sizes, shades(len(sizes)), strict=True)
    ]


def _stalls(results: xr.Dataset, axes: Axes) -> None:
    """Draw the stall angle against the size of the cell, the solved cells and Eq. 32."""
    sizes = results["stall_curve_domain_size"].to_numpy()
    angle, paper = (
        np.degrees(results[f"stall_curve_{name}"].to_numpy()) for name in ("angle", "paper")
    )
    largest = float(results["largest_stalling_domain"])
    axes.plot(sizes, angle, color=VERMILION, linewidth=1.6, label="computed")
    axes.plot(sizes, paper, label="paper's Eq. 32", **PAPER)
    solved = results["stall_domain_size"].to_numpy()
    factor = results["stall_shape_factor"].to_numpy()
    here = factor >= 1.0
    axes.plot(
        solved[here],
        np.degrees(0.5 * np.arccos(1.0 / factor[here])),
        linestyle="none",
        marker="o",
        markersize=3.5,
        markerfacecolor="white",
        markeredgecolor=VERMILION,
        label="cells solved",
        zorder=3,
    )
    axes.axvline(largest, color=GREY, linewidth=0.8, linestyle=(0, (1, 1.5)))
    axes.annotate(
        f"none above\nM = {largest:.2f}",
        (largest, 0.62),
        xycoords=("data", "axes fraction"),
        xytext=(-3, 0),
        textcoords="offset points",
        ha="right",
    )
    axes.set_xlim(2.0, largest + 0.05 * (largest - 2.0))
    axes.set_ylim(0.0, 1.1 * float(angle.max()))
    axes.set_xlabel("domain size M")
    axes.set_ylabel("stall angle [°]")
    axes.legend(loc="lower left")
    _grid(axes)
    letter(axes, "c  stall angle against the cell")


def _look(results: xr.Dataset, closure: str) -> dict[str, Any]:
    """Return the look of a closure's line: wide if it is the study's."""
    look = {"linewidth": FINE, "zorder": 2} | LOOKS.get(closure, {"color": GREY})
    if closure == str(results["interaction_closure"].item()):
        look |= {"linewidth": BOLD, "zorder": 1.8, "linestyle": "-"}
    return look


def _stretched(results: xr.Dataset) -> list[str]:
    """Return what is drawn in the paper's convention too: the study's closure, the distribution."""
    own = str(results["interaction_closure"].item())
    return [name for name in (own, "exact-pdf") if name in results["closure"].to_numpy()]


def _stretch(results: xr.Dataset, closure: str) -> dict[str, Any]:
    """Return the look of a closure's line in the paper's convention."""
    return _look(results, closure) | STRETCHED


def _preferred(results: xr.Dataset, axes: Axes) -> None:
    """Draw preferred angles against the interaction coefficient, and Eq. 33."""
    interaction = results["interaction"].to_numpy()
    angle = results["interaction_angle"] * DEGREES
    for closure in map(str, results["closure"].to_numpy()):
        found = angle.sel(convention="standard", closure=closure).to_numpy()
        axes.plot(interaction, found, **_look(results, closure))
    for closure in _stretched(results):
        found = angle.sel(convention="paper", closure=closure).to_numpy()
        axes.plot(interaction, found, **_stretch(results, closure))
    axes.plot(interaction, np.degrees(results["interaction_angle_paper"].to_numpy()), **PAPER)
    axes.set_xlim(0.0, float(interaction[-1]))
    axes.set_ylim(0.0, 1.05 * float(np.nanmax(angle.to_numpy())))
    axes.set_xlabel("interaction coefficient $C_I$")
    axes.set_ylabel("preferred angle [°]")
    axes.xaxis.set_major_locator(MultipleLocator(0.01))
    _grid(axes)
    letter(axes, "d  preferred angle of a suspension")


def _closures_key(results: xr.Dataset) -> list[Line2D]:
    def named(closure: str) -> str:
        return NAMES.get(closure, closure)

    names = [str(name) for name in results["closure"].to_numpy()]
    lines = [Line2D([], [], label=named(c), **_look(results, c)) for c in names]
    lines += [
        Line2D([], [], label=f"{named(c)},\npaper's conv.", **_stretch(results, c))
        for c in _stretched(results)
    ]
    return [*lines, Line2D([], [], label="paper's Eq. 33", **PAPER)]


def sizes_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text."""
    closure = str(results["interaction_closure"].item())
    own, size = float(results["interaction_coefficient"]), float(results["content_domain_size"])
    apart = " and ".join(
        f"{'not to be compared' if np.isnan(value) else f'{value:.3f}'} in the {name} convention"
        for name, value in _by_convention(results, "interaction_domain_size_difference")
    )
    ends = []
    for convention in map(str, results["convention"].values):
        curve = results["interaction_domain_size"].sel(convention=convention).to_numpy()
        here = curve[np.isfinite(curve)]
        told = f"from {here[0]:.2f} to {here[-1]:.2f}" if here.size else "nowhere: no cell stalls"
        ends.append(f"{told} in the {convention} convention")
    return Words(
        caption=(
            f"{_fibers(results)} Size of the cell in which a fiber stalls at the preferred angle "
            f"of its suspension, by the closure {closure}, in both conventions of the rate of "
            "deformation that multiplies the interaction coefficient; a line ends where no cell "
            "stalls the fiber at the angle. Diamond: this study's content, "
            f"C_I = {own:.4f}, M = {size:.3f} ({results['content_regime'].item()}). Largest "
            f"difference from the paper's Eq. 34: {apart}."
        ),
        alt=(
            "Two curves that fall with the interaction coefficient, and the paper's beside them. "
            f"Over C_I of {float(results['interaction'][0]):.3f} to "
            f"{float(results['interaction'][-1]):.3f} the domain size falls {', '.join(ends)}. "
            f"The study's content is at C_I = {own:.4f}, M = {size:.2f}."
        ),
    )


@plate(
    "interaction-domain-size",
    "The cell that stands for interaction",
    section="content",
    words=sizes_words,
    needs="interaction_angle",
    paper="Fig. 15",
)
def figure_sizes(results: xr.Dataset) -> Figure:
    """Draw the size of the cell against the interaction coefficient, and Eq. 34 (Fig. 15)."""
    figure = new_figure(COLUMN, 72)
    axes = add_axes(figure, 11, 10, 75, 48)
    interaction = results["interaction"].to_numpy()
    closure = str(results["interaction_closure"].item())
    for convention, color in CONVENTIONS.items():
        sizes = results["interaction_domain_size"].sel(convention=convention).to_numpy()
        label = f"{closure}, {convention} convention"
        axes.plot(interaction, sizes, color=color, linewidth=1.6, label=label)
    axes.plot(
        interaction,
        results["interaction_domain_size_paper"].to_numpy(),
        label="paper's Eq. 34",
        **PAPER,
    )
    own = float(results["interaction_coefficient"])
    axes.plot(
        own,
        float(results["content_domain_size"]),
        linestyle="none",
        marker="D",
        markersize=5.5,
        markerfacecolor="white",
        markeredgecolor=INK,
        label="this study's content",
        zorder=5,
    )
    axes.set_xlim(0.0, 1.02 * max(float(interaction[-1]), own))
    axes.set_xlabel("interaction coefficient $C_I$")
    axes.set_ylabel("domain size M")
    _grid(axes)
    axes.legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.02), ncols=2, columnspacing=1.4, handlelength=2.2
    )
    return figure
