"""The variables of the paper's claims in results.nc; merged into `study.variables`."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["CLAIM_VARIABLES"]

CLAIM_VARIABLES: Mapping[str, tuple[str, str, str]] = {
    "claim": ("claim", "1", "name of the claim, as in data/claims.toml"),
    "claim_value": (
        "claim",
        "1",
        "what it is judged by, in its unit; NaN if not to be had",
    ),
    "claim_missing": ("claim", "1", "why it is not to be had"),
}
"""``{name: (dimensions, unit, long name)}``, as `fibermelt.parts.variables.VARIABLES`."""
