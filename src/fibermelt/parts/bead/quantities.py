"""What is stored of the fiber's cell, of its motion and of the pressure on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.engine.quantities import Derive, declared
from fibermelt.engine.quantities import Quantity as Q

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["QUANTITIES"]

_PATH = "streamline point"
_FIBER = "streamline initial_angle point"
_TABLE = "thinning_rate thinning_phase"
_EXTREME = "streamline initial_angle location kind"


def _lowest_mean(location: int) -> Derive:
    """Return the function that finds the lowest mean over initial angles at a location.

    Of each streamline that passes no sharp corner the lowest surface pressure at the location,
    mean over the initial angles; of those the lowest.
    """

    def lowest(collected: xr.Dataset) -> xr.DataArray | None:
        if not {"extreme_mean", "near_singularity"} <= set(map(str, collected)):
            return None
        if not {"location", "kind", "streamline"} <= set(map(str, collected["extreme_mean"].dims)):
            return None
        if location not in collected["location"].to_numpy():
            return None
        extreme = collected["extreme_mean"].sel(location=location, kind="min")
        return extreme.where(collected["near_singularity"] == 0).min("streamline")

    return lowest


# fmt: off
QUANTITIES = declared(
    # The labels of the dimensions.
    Q("initial_angle", "initial_angle", "rad", "angle of the fiber at the inlet", swept="reduced"),
    Q("initial_elevation", "initial_angle", "rad", "angle out of the plane at the inlet"),
    Q("location", "location", "1",
      "0 the whole way, 1 before the capillary, 2 from the exit to the end of the swell",
      swept="kept"),
    Q("kind", "kind", "1", "min or max of surface pressure less streamline pressure", swept="kept"),
    Q("quantile", "quantile", "1", "share of isotropically entering fibers that lie below",
      swept="kept"),
    Q("side", "side", "1", "lower and upper bound; has no labels", stored=False, swept="kept"),
    # What a sweep derives: of streamlines that pass no sharp corner, the lowest.
    *(Q(f"lowest_mean_{location}", "", "Pa",
        f"lowest pressure on a fiber's surface, over the melt's{where}: the mean over "
        "the initial angles, on the streamline where it is lowest",
        title=f"Lowest pressure on fibers, mean over initial angles{title}", shown_in="MPa",
        stored=False, response=True, derive=_lowest_mean(location))
      for location, where, title in (
          (0, "", ""),
          (1, ", before the capillary", ", Loc. 1"),
          (2, ", from the exit to the end of the swell", ", Loc. 2"),
      )),
    # The fiber's cell.
    Q("fiber_model", "", "1", "what answers for the fiber"),
    Q("aspect_ratio", "", "1", "length over width of the fiber", title="Aspect ratio"),
    Q("thickness_ratio", "", "1", "length over thickness of an ellipsoid of three axes"),
    Q("domain_size", "", "1", "domain-size factor M; NaN if unbounded",
      title="Domain-size factor M", none="unbounded"),
    Q("shape_factor", "", "1", "shape factor B; Jeffery's xi if unbounded", title="Shape factor B"),
    Q("stall_angle", "", "rad", "angle to simple shear at which it stalls; NaN if it tumbles",
      title="Stall angle", shown_in="°", none="it tumbles"),
    Q("tip_pressure", "", "1",
      "largest surface pressure on a fiber in simple shear, in any direction, over mu gamma_dot",
      title="Tip pressure over μγ̇", response=True),
    Q("shape_factor_error", "", "1", "estimated absolute error of the shape factor"),
    Q("tip_pressure_error", "", "1", "estimated relative error of the tip pressure", relative=True),
    Q("cell_unknowns", "", "1", "unknowns of the cell", title="Unknowns of the cell",
      response=False),
    Q("surface_angle", "surface", "rad", "eccentric angle on the fiber's surface"),
    Q("surface_basis", "surface mode", "1", "surface pressure over mu D_11 and mu D_12"),
    Q("cell_point", "cell_node component", "1", "nodes around the fiber, over its half-length"),
    Q("cell_triangle", "cell_element corner", "1", "triangles to draw the cell with"),
    Q("cell_edge", "cell_line cell_place", "1", "nodes along the curved edges of the elements"),
    Q("cell_velocity", "cell_node mode component", "1", "velocity of the basis solutions"),
    Q("cell_pressure", "cell_node mode", "1", "pressure of the basis solutions"),
    # The fiber in a melt that thins.
    Q("thinning_aspect_ratio", "", "1", "length over width of the fiber of the table"),
    Q("thinning_rate", "thinning_rate", "1/s", "rates of deformation of the far field"),
    Q("thinning_spin", "thinning_rate thinning_term", "1",
      "spin over half the rate: terms in sin (2k + 1) phi, phi twice the angle to the stretch"),
    Q("thinning_lowest", _TABLE, "1", "lowest surface pressure over eta times half the rate"),
    Q("thinning_highest", _TABLE, "1", "highest surface pressure over eta times half the rate"),
    Q("thinning_where_lowest", _TABLE, "rad", "eccentric angle of the lowest pressure"),
    Q("thinning_where_highest", _TABLE, "rad", "eccentric angle of the highest pressure"),
    Q("thinning_tip", _TABLE, "1", "pressure at the tip over eta times half the rate"),
    Q("thinning_surface", "thinning_surface", "rad", "eccentric angles of the surface's points"),
    Q("thinning_pressure", "thinning_rate thinning_direction thinning_surface", "1",
      "surface pressure over eta times half the rate, at the directions that were solved for"),
    Q("thinning_spin_error", "", "1", "estimated error of the spin over half the rate"),
    Q("thinning_pressure_error", "", "1", "estimated error of the extremes over the largest",
      relative=True),
    Q("around_streamline", "", "1", "number of the streamline of the fiber of around_pressure"),
    Q("around_initial_angle", "", "rad", "angle at which that fiber enters"),
    Q("around_time", "", "s", "when its pressure is lowest before the capillary"),
    Q("around_point", "around_node component", "1",
      "nodes around that fiber then, in its axes, over its half-length"),
    Q("around_triangle", "around_element corner", "1", "triangles to draw them with"),
    Q("around_velocity", "around_node component", "1/s",
      "velocity less that of the fiber's center along the flow's axes, over its half-length"),
    Q("around_pressure", "around_node", "Pa", "pressure less the streamline's"),
    # The fibers along the streamlines.
    Q("angle", _FIBER, "rad", "angle of the fiber from the x axis"),
    Q("elevation", _FIBER, "rad", "angle of the fiber out of the plane of the flow"),
    Q("lowest", _FIBER, "Pa", "lowest surface pressure less streamline pressure"),
    Q("highest", _FIBER, "Pa", "highest surface pressure less streamline pressure"),
    Q("bound_lowest", _PATH, "Pa", "lowest surface pressure over every orientation"),
    Q("felt_lowest", _PATH, "Pa",
      "lowest surface pressure over every orientation, with the most that is felt near corners",
      shown_in="MPa"),
    Q("bound_highest", _PATH, "Pa", "highest surface pressure over every orientation"),
    Q("quantile_lowest", f"{_PATH} quantile", "Pa", "lowest pressure of isotropic fibers"),
    Q("quantile_highest", f"{_PATH} quantile", "Pa", "highest pressure of isotropic fibers"),
    Q("extreme", _EXTREME, "Pa", "extreme of surface pressure less streamline pressure",
      shown_in="MPa"),
    Q("extreme_x", _EXTREME, "m", "x of the extreme"),
    Q("extreme_y", _EXTREME, "m", "y of the extreme"),
    Q("extreme_z", _EXTREME, "m", "z of the extreme"),
    Q("extreme_error", _EXTREME, "Pa",
      "estimated error of the extreme, by the points' spacing and the gradient's"),
    Q("extreme_time", _EXTREME, "s", "time of the extreme"),
    Q("extreme_pressure", _EXTREME, "Pa", "pressure at the extreme above the surrounding air's"),
    Q("extreme_angle", _EXTREME, "rad", "angle of the fiber to the streamline at the extreme"),
    Q("extreme_where", _EXTREME, "rad", "eccentric angle of the extreme on the surface"),
    Q("extreme_bounds", "streamline location kind side", "Pa",
      "bounds of the extreme over every orientation"),
    Q("extreme_quantiles", "streamline location kind quantile", "Pa",
      "quantiles of the extreme for an isotropic start"),
    Q("extreme_quantiles_error", "streamline location kind quantile", "Pa",
      "estimated error of the quantiles, by the number of fibers"),
    Q("zone_angle", "streamline initial_angle zone", "rad",
      "angle of the fiber to the streamline at the zone"),
)
# fmt: on
"""What this part stores, by name."""
