"""What the paper's claims are judged by: numbers, in SI, as functions of the results.

Streamlines that pass close by a singular corner are left out of all of them: what a fiber sees
there has no limit as the mesh is refined.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["NotStoredError", "Quantity", "by_name", "needing"]

Quantity = Callable[["xr.Dataset"], float]
"""From results to a number in SI; `NotStoredError` if they do not have it."""


class NotStoredError(LookupError):
    """The results do not have what a quantity is made of."""


def needing(*variables: str, part: str) -> Callable[[Quantity], Quantity]:
    """Say which variables a quantity reads, and which part of a study has them."""

    def declared(compute: Quantity) -> Quantity:
        @wraps(compute)
        def checked(results: xr.Dataset) -> float:
            if any(name not in results for name in variables):
                msg = f'the study has no part "{part}"'
                raise NotStoredError(msg)
            return compute(results)

        return checked

    return declared


def by_name(*quantities: Quantity) -> dict[str, Quantity]:
    """Return quantities by their functions' names, as claims call them."""
    return {compute.__name__: compute for compute in quantities}
