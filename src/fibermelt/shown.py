"""Values that say in a line what they are, and in a notebook in a small table."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

__all__ = ["Shown"]


class Shown:
    """Base of values whose arrays are too long to be printed.

    A dataclass that is one says ``repr=False``, as it would write one of its own.
    """

    def told(self) -> Mapping[str, str]:
        """Return what it tells of itself: each number with its unit, by what it is."""
        raise NotImplementedError

    def __repr__(self) -> str:
        """Return its type and what it tells, in a line."""
        inside = ", ".join(f"{name} {value}" for name, value in self.told().items())
        return f"{type(self).__name__}({inside})"

    def _repr_html_(self) -> str:
        """Return the same as a table."""
        rows = "".join(
            f'<tr><th scope="row">{escape(name)}</th><td>{escape(value)}</td></tr>'
            for name, value in self.told().items()
        )
        return f"<table><caption>{type(self).__name__}</caption><tbody>{rows}</tbody></table>"
