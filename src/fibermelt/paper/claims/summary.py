"""What summary.json says of the claims, as a function of the results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fibermelt.engine.results import has_conditions_of_paper
from fibermelt.paper.claims.judge import Verdict, claims, judge

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["claims_in_words", "summarize_claims"]


def summarize_claims(results: xr.Dataset) -> dict[str, Any]:
    """Return what summary.json says of the claims.

    Parameters
    ----------
    results : xarray.Dataset
        As in results.nc, with the claims' quantities.

    Returns
    -------
    dict
        ``{"claims": [{"id", "section", "statement", "paper", "measure", "passes_if", "ours",
        "verdict", "reason"}, ...]}``, numbers with their units as text. ``paper`` is the number
        that the paper gives, empty where it says ``statement`` in words only; ``passes_if`` is
        what we take either to mean.
    """
    values = dict(zip(results["claim"].to_numpy(), results["claim_value"].to_numpy(), strict=True))
    why = dict(zip(results["claim"].to_numpy(), results["claim_missing"].to_numpy(), strict=True))
    same = has_conditions_of_paper(results)
    found = [
        judge(claim, float(values[claim.id]), str(why[claim.id]), as_in_paper=same)
        for claim in claims()
    ]
    return {
        "claims": [
            {
                "id": one.claim.id,
                "section": one.claim.section,
                "statement": one.claim.statement,
                "paper": one.claim.said,
                "measure": one.claim.measure,
                "passes_if": one.claim.passes_if,
                "ours": one.ours,
                "verdict": one.verdict,
                "reason": one.reason,
            }
            for one in found
        ]
    }


def claims_in_words(summary: Mapping[str, Any]) -> list[str]:
    """Return the claims' verdicts as a table for a terminal, and how many there are of each."""
    rows = [
        (
            one["id"],
            one["paper"] or "in words",
            one["passes_if"],
            one["ours"] or "-",
            one["verdict"],
        )
        for one in summary["claims"]
    ]
    heads = ("claim", "the paper says", "passes if", "ours", "verdict")
    widths = [max(len(row[k]) for row in (heads, *rows)) for k in range(len(heads))]
    lines = [
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip()
        for row in (heads, *rows)
    ]
    verdicts = [one["verdict"] for one in summary["claims"]]
    kinds: tuple[Verdict, ...] = ("holds", "differs", "cannot be judged")
    tally = ", ".join(f"{verdicts.count(kind)} {kind}" for kind in kinds)
    return ["", *lines, "", f"claims          {tally}"]
