"""All figures of a study: what they are called, how they are drawn, what they say in words.

Each figure is a pure function of the results; `draw_figures` writes them as SVG and PNG. The same
results give the same bytes with the same version of matplotlib.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from fibermelt.paper.orbits.figures.plates import DIMENSION_FIGURES, ORBIT_FIGURES
from fibermelt.parts.bead.figures.alignment import alignment_words, figure_alignment
from fibermelt.parts.bead.figures.cell import cell_words, figure_cell
from fibermelt.parts.bead.figures.extremes import extremes_words, figure_extremes
from fibermelt.parts.bead.figures.overview import figure_overview, overview_words
from fibermelt.parts.bead.figures.paths import (
    figure_path_extremes,
    figure_path_histories,
    figure_paths,
    path_extremes_words,
    path_histories_words,
    paths_words,
)
from fibermelt.parts.bead.figures.positions import figure_positions, positions_words
from fibermelt.parts.bead.figures.pressure_history import figure_history, history_words
from fibermelt.parts.bead.figures.profiles import figure_profiles, profiles_words
from fibermelt.parts.flow.figures.along import along_words, figure_along
from fibermelt.parts.flow.figures.domain import domain_words, figure_domain
from fibermelt.parts.flow.figures.maps import (
    figure_gradients,
    figure_maps,
    gradients_words,
    maps_words,
)
from fibermelt.parts.flow.figures.streamlines import figure_streamlines, streamlines_words
from fibermelt.parts.interaction.figures import INTERACTION_FIGURES
from fibermelt.parts.melt.figures import figure_melt, melt_words
from fibermelt.parts.orientation.figures.orientation import ORIENTATION_FIGURES
from fibermelt.parts.thinning.figures import figure_thinning, thinning_words
from fibermelt.parts.voids.figures import figure_voids, voids_words
from fibermelt.report.kit.plates import Plate, draw_plates

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["FIGURES", "draw_figures"]


SOLVED = "extreme node_x"
"""What only the results of a deposition flow that was solved have."""

GIVEN = "extreme field_notes"
"""What only those of a flow from elsewhere have."""

FIGURES = (
    Plate("overview", "The bead at a glance", figure_overview, overview_words, needs=SOLVED),
    Plate("melt", "The melt", figure_melt, melt_words, needs="law_rate"),
    Plate(
        "domain",
        "Fluid domain and mesh",
        figure_domain,
        domain_words,
        needs=SOLVED,
        paper="Fig. 2a",
    ),
    Plate(
        "streamlines",
        "Streamlines",
        figure_streamlines,
        streamlines_words,
        needs=SOLVED,
        paper="Fig. 2b",
    ),
    Plate(
        "along",
        "Speed and deformation along streamlines",
        figure_along,
        along_words,
        needs=SOLVED,
        paper="Fig. 3",
    ),
    Plate("maps", "Speed, rate of deformation and pressure", figure_maps, maps_words, needs=SOLVED),
    Plate(
        "gradients",
        "Velocity gradient near the exit",
        figure_gradients,
        gradients_words,
        needs=SOLVED,
        paper="Fig. 4",
    ),
    Plate("cell", "The fiber's cell", figure_cell, cell_words, paper="Fig. 5a and 6a"),
    *ORBIT_FIGURES,
    *DIMENSION_FIGURES,
    Plate("thinning", "What thinning does", figure_thinning, thinning_words, needs="effect_index"),
    *INTERACTION_FIGURES,
    Plate(
        "history",
        "Pressure on a fiber along a streamline",
        figure_history,
        history_words,
        needs=SOLVED,
        paper="Fig. 16",
    ),
    Plate(
        "profiles",
        "Pressure and orientation over time",
        figure_profiles,
        profiles_words,
        needs=SOLVED,
        paper="Fig. 17",
    ),
    Plate(
        "extremes",
        "Extremes of pressure by streamline",
        figure_extremes,
        extremes_words,
        needs=SOLVED,
        paper="Fig. 18",
    ),
    Plate(
        "positions",
        "Where the extremes lie",
        figure_positions,
        positions_words,
        needs=SOLVED,
        paper="Fig. 19",
    ),
    Plate(
        "alignment",
        "Orientation at the zones",
        figure_alignment,
        alignment_words,
        needs="zone_angle",
        paper="Fig. 20",
    ),
    *ORIENTATION_FIGURES,
    Plate(
        "voids", "Where voids can start", figure_voids, voids_words, needs=f"void_margin {SOLVED}"
    ),
    Plate("paths", "The paths", figure_paths, paths_words, needs=GIVEN),
    Plate(
        "path-histories",
        "Pressure on fibers along paths",
        figure_path_histories,
        path_histories_words,
        needs=GIVEN,
    ),
    Plate(
        "path-extremes",
        "Extremes of pressure by path",
        figure_path_extremes,
        path_extremes_words,
        needs=GIVEN,
    ),
)
"""The figures in the order of a report."""


def draw_figures(results: xr.Dataset, directory: Path) -> list[Path]:
    """Draw every figure that the results are enough for, as SVG and PNG, and return the paths.

    Parameters
    ----------
    results : xarray.Dataset
        Results of a study, as in results.nc.
    directory : Path
        An existing folder.
    """
    there = (plate for plate in FIGURES if plate.is_of(results))
    return draw_plates(there, results, directory)
