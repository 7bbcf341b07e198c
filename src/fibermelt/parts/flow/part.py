"""The flow as a part of studies: solved or given, and the paths through it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from fibermelt.engine.parts import Part
from fibermelt.engine.stages import Stage
from fibermelt.parts.flow.config import FLOW_NUMERICS, Flow, Numerics, Strand, Streamlines
from fibermelt.parts.flow.field_table import ImportedField
from fibermelt.parts.flow.paths_table import Paths
from fibermelt.parts.melt.melt import LAW

if TYPE_CHECKING:
    from fibermelt.engine.parameters import Value

__all__ = ["PART"]

HERE = "fibermelt.parts.flow"


def _flow_of(values: Mapping[str, Value]) -> tuple[str, ...]:
    """Return where the paths lead through: a deposition flow, a field, or nothing."""
    return {
        "deposition": ("flow",),
        "deposition-3d": ("strand",),
        "field": ("field",),
        "histories": (),
    }[str(values["flow.source"])]


PART = Part(
    "flow",
    tables={
        "flow": Flow,
        "streamlines": Streamlines,
        "field": ImportedField,
        "paths": Paths,
        "numerics": Numerics,
        "strand": Strand,
    },
    brings=(
        Stage(
            "flow",
            8,
            ("flow", LAW, *FLOW_NUMERICS),
            (),
            f"{HERE}.stages:flow_stage",
            compute_from=f"{HERE}.stages:flow_from",
            scaled=f"{HERE}.stages:flow_scaled",
            estimates=f"{HERE}.stages:flow_estimates",
        ),
        Stage(
            "strand",
            1,
            ("flow", LAW, "strand"),
            (),
            f"{HERE}.strand:strand_stage",
            estimates=f"{HERE}.strand:strand_estimates",
        ),
        Stage("field", 5, ("field",), (), f"{HERE}.imported:field_stage"),
        Stage(
            "streamlines",
            5,
            ("flow", LAW, "streamlines.count", "streamlines.points", "paths"),
            (),
            f"{HERE}.stages:streamlines_stage",
            told_with="flow",
            inputs_if=_flow_of,
            estimates=f"{HERE}.stages:streamline_estimates",
        ),
    ),
    refuse=f"{HERE}.checks:refuse_sources",
    notes=f"{HERE}.checks:flow_notes",
)
