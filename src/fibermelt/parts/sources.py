"""Where the defaults of a study come from, and what its ranges mean."""

from __future__ import annotations

__all__ = ["INFERRED", "PAPER_2", "PAPER_3", "PAPER_21", "PAPER_25", "TABLE_1", "VERIFIED"]

INFERRED = "inferred: the paper prints no dimensions; these reproduce its stated results"
PAPER_2 = "the paper, section 2 (after Heller et al. and Wang et al.)"
PAPER_21 = "the paper, section 2.1 (after Heller et al. and Wang et al.)"
PAPER_25 = "the paper, section 2.5"
PAPER_3 = "the paper, section 3"
TABLE_1 = "the paper, Table 1"

VERIFIED = "the fiber's cell is verified in this range only"
"""What it says of a value that it lies beyond the range."""
