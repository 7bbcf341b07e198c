"""Captions and alternative texts of the figures on interaction, with their numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fibermelt.report.kit.style import Words

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["interaction_words", "sizes_words"]

PAPER_RATIO = 6.0
"""Aspect ratio of the paper's polynomials."""


def _angle(radians: float) -> str:
    """Return an angle in both units, or that there is none."""
    if np.isnan(radians):
        return "nowhere to compare with"
    return f"{radians:.4f} rad ({np.degrees(radians):.2f}°)"


def _by_convention(results: xr.Dataset, name: str) -> list[tuple[str, float]]:
    values = results[name].to_numpy()
    return [(str(c), float(v)) for c, v in zip(results["convention"].values, values, strict=True)]


def _fibers(results: xr.Dataset) -> str:
    """Return whose curves these are, and that the paper's are of others if they are."""
    ratio = float(results["stall_aspect_ratio"])
    if ratio == PAPER_RATIO:
        return f"Fibers of aspect ratio {ratio:g}."
    return (
        f"Fibers of aspect ratio {ratio:g}; the paper's polynomials are of {PAPER_RATIO:g}, and "
        "differ for that alone."
    )


def _missing(results: xr.Dataset) -> str:
    """Return which curves have gaps, if any."""
    angle = results["interaction_angle"].sel(convention="standard")
    gaps = [str(c) for c in results["closure"].values if np.isnan(angle.sel(closure=c)).any()]
    return f" Not everywhere with a steady state: {', '.join(gaps)}." if gaps else ""


def interaction_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text of `figure_interaction`."""
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


def sizes_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text of `figure_sizes`."""
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
