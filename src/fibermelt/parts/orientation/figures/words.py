"""Captions and alternative texts of the figures on orientation, with their numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fibermelt.parts.flow.figures.lines import features, line_word
from fibermelt.parts.flow.imported import is_given
from fibermelt.parts.interaction.models import model_in_words
from fibermelt.parts.orientation.figures.tensors import (
    angle_from,
    closure_row,
    component_along,
    tensors,
)
from fibermelt.parts.orientation.summary import stored_model
from fibermelt.report.kit.scene import MM
from fibermelt.report.kit.style import Words
from fibermelt.report.kit.tables import number, sized

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["across_words", "history_words"]


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


def across_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text of `figure_across`."""
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


def history_words(results: xr.Dataset) -> Words:
    """Return caption and alternative text of `figure_tensor_history`."""
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
