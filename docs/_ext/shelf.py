"""The order of the examples in the gallery: first the chain, then flows and models of one's own."""

from __future__ import annotations

__all__ = ["ORDER", "Shelf"]

ORDER = (
    *("lowest_pressure.py", "one_turn.py", "content_to_cell.py", "how_dry.py"),
    *("own_streamline.py", "foreign_flow.py", "one_flow_six_files.py"),
    *("nozzle_of_openfoam.py", "pipe_in_space.py", "own_closure.py", "sweep_on_slurm.py"),
)
"""Files of the examples; one that is not named here comes last."""


class Shelf:
    """Key to sort by, as sphinx-gallery asks for it: made with a folder, called with a file."""

    def __init__(self, folder: str) -> None:
        self.folder = folder

    def __call__(self, name: str) -> tuple[int, str]:
        """Return the place of an example."""
        return (ORDER.index(name) if name in ORDER else len(ORDER), name)
