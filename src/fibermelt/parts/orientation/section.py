"""The section on orientation tensors in the bead, or along paths from elsewhere."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.parts.flow.figures.lines import line_word
from fibermelt.parts.flow.given import is_given
from fibermelt.parts.interaction.models import model_in_words
from fibermelt.parts.orientation.figures import angle_from, tensors
from fibermelt.parts.orientation.summary import stored_model
from fibermelt.report.kit.sections import section
from fibermelt.report.kit.tables import Column, Table, fixed

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["orientation"]


@section(
    "tensors",
    "Orientation in the bead",
    place=70,
    needs="orientation_tensor",
    of_paths="Orientation along the paths",
)
def orientation(results: xr.Dataset, summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the orientation tensor in the bead, or where paths end, and the closure's error."""
    near = results["near_singularity"].to_numpy().astype(bool)
    word, given = line_word(results), is_given(results)
    columns = (
        Column(word.capitalize(), is_text=True),
        *(Column(name) for name in ("a_xx", "a_yy", "a_zz", "a_xy")),
        Column(f"Mean direction to {'the x axis' if given else 'the bed'}", "°"),
    )
    rows = [
        (
            f"{number}{'*' if is_near else ''}",
            *(fixed(float(a[i, j]), 3) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1))),
            fixed(math.degrees(float(angle_from(a))), 1),
        )
        for number, is_near, a in zip(
            results["streamline"].to_numpy().tolist(), near, tensors(results)[:, -1], strict=True
        )
    ]
    where = "where paths end" if given else "at the outlet"
    return {
        "found": summary["orientation_tensor"],
        "is_given": given,
        "word": word,
        "model": model_in_words(*stored_model(results)),
        "closure": str(results["orientation_closure"].item()),
        "outlet": Table(f"Orientation tensor {where} by {word}", columns, rows),
        "is_near_corner": bool(near.any()),
    }
