"""The figures of the sensitivity studies: the paper's Fig. 8 to 13, and 2D against 3D."""

from __future__ import annotations

from fibermelt.paper.dimensions.figures import dimensions_words, figure_dimensions
from fibermelt.paper.orbits.figures.around import around_words, figure_around
from fibermelt.paper.orbits.figures.orbits import (
    figure_motion,
    figure_pressures,
    motion_words,
    pressures_words,
)
from fibermelt.paper.orbits.figures.over_parameters import sweep_figure, sweep_words
from fibermelt.report.kit.plates import Plate

__all__ = ["DIMENSION_FIGURES", "ORBIT_FIGURES"]


ORBITS, DIMENSIONS = "orbit_period", "peak_pressure"
"""Variables that only the stage has whose figures they are."""


def _sweep(name: str, title: str, paper: str) -> Plate:
    plate = f"orbit-{name.replace('_', '-')}"
    return Plate(plate, title, sweep_figure(name), sweep_words(name), ORBITS, paper)


ORBIT_FIGURES = (
    Plate(
        "orbit-motion",
        "A fiber's turn in simple shear",
        figure_motion,
        motion_words,
        ORBITS,
        "Fig. 8",
    ),
    Plate(
        "orbit-pressure",
        "Pressure over a turn",
        figure_pressures,
        pressures_words,
        ORBITS,
        "Fig. 9",
    ),
    _sweep("aspect_ratio", "Pressure over half a turn by aspect ratio", "Fig. 10"),
    Plate(
        "orbit-around", "Pressure around the fiber", figure_around, around_words, ORBITS, "Fig. 11"
    ),
    _sweep("shear_rate", "Pressure over half a turn by shear rate", "Fig. 12"),
    _sweep("viscosity", "Pressure over half a turn by viscosity", "Fig. 13"),
)
"""What is drawn of the stage "orbits": Fig. 8, 9, 10, 11, 12, 13, in this order."""

DIMENSION_FIGURES = (
    Plate(
        "dimensions",
        "Two dimensions against three",
        figure_dimensions,
        dimensions_words,
        DIMENSIONS,
    ),
)
"""What is drawn of the stage "dimensions"."""
