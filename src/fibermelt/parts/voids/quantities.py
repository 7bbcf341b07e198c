"""What is stored of voids.

Pressures of voids are absolute. NaN stands for what there is none of, as each long name says.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["QUANTITIES"]

_LINE = "streamline void_basis"
_LAYER = "void_selection void_layer void_basis"
_BEAD = "void_selection void_basis"


def _moisture(collected: xr.Dataset) -> xr.DataArray | None:
    """Return the critical moisture; saturation where any moisture that can be is harmless."""
    if "void_critical_moisture" not in collected:
        return None
    worst = collected["void_critical_moisture"]
    needed = ("void_critical_moisture_mean", "void_saturation_moisture")
    if not all(name in collected for name in needed):
        return worst
    mean, most = (collected[name] for name in needed)
    return worst.where(~(worst.isnull() & mean.notnull()), most)


# fmt: off
QUANTITIES = declared(
    # The labels of the dimensions.
    Q("void_basis", "void_basis", "1",
      "whose lowest pressure: the melt's own; that which a share [%] of isotropically entering "
      "fibers stays below at a point; fibers: the worst of the initial angles; bounds: any "
      "direction; felt: the same, with the most that is felt near sharp corners; spheroid: an "
      "unbounded spheroid of the same aspect ratio in any direction, in a melt that thins in any "
      "of the flow's plane; oriented tips: at the tips of such spheroids, mean over their "
      "orientation tensor", swept="kept"),
    Q("void_selection", "void_selection", "1",
      "regular: without the streamlines that pass close by a sharp corner; all", swept="kept"),
    Q("void_layer", "void_layer", "m", "middle of the layer above the bed in the finished bead",
      swept="kept", kept_as="void_layer_middle", shown_in="mm"),
    Q("void_station", "void_station", "1",
      "when nuclei are told: at the end of the swell, which is zone 3 or the end of a path without "
      "zones, and some time later on the bed", swept="kept"),
    Q("void_step", "void_step", "1", "step of a nucleus in time; has no labels", stored=False),
    # The melt.
    Q("void_material", "", "1", "key of the material card"),
    Q("void_material_name", "", "1", "what the material is called"),
    Q("void_estimates", "", "1", "keys of the card that are estimates"),
    Q("void_missing", "", "1", "what the card cannot give, a sentence each line"),
    Q("void_moisture", "", "1", "moisture over the mass of polymer"),
    Q("void_temperature", "", "K", "temperature of the melt"),
    Q("void_saturation_moisture", "", "1", "most moisture that the polymer can hold"),
    Q("void_boiling_moisture", "", "1",
      "moisture above which the melt boils at rest in the air; NaN where none that it can hold "
      "does"),
    Q("void_vapor_pressure", "", "Pa", "absolute vapor pressure of the moisture", shown_in="MPa"),
    Q("void_saturation_pressure", "", "Pa", "absolute saturation pressure of water"),
    Q("void_threshold", "", "1", "log10 of the rate [1/(m^3 s)] that counts as nucleation"),
    Q("void_speed_exponent", "", "1",
      "power of both speeds that pressures above the air's go with; NaN if it is no power"),
    # Along the streamlines.
    Q("void_margin_along", f"{_LINE} point", "Pa",
      "local pressure less vapor pressure: negative where a bubble can grow"),
    Q("void_height", "streamline", "m", "height of the streamline in the finished bead",
      shown_in="mm"),
    Q("void_lowest_pressure", _LINE, "Pa", "lowest absolute local pressure on the streamline",
      shown_in="MPa"),
    Q("void_lowest_x", _LINE, "m", "x of the lowest pressure, from the nozzle's axis"),
    Q("void_lowest_y", _LINE, "m", "y of the lowest pressure, from the bed"),
    Q("void_lowest_z", _LINE, "m", "z of the lowest pressure, of paths in space"),
    Q("void_margin", _LINE, "Pa", "lowest pressure less vapor pressure"),
    Q("void_time_below", _LINE, "s", "time below the vapor pressure, up to the outlet"),
    Q("void_first_below", _LINE, "s", "first time below the vapor pressure; NaN if never"),
    Q("void_log10_rate", _LINE, "1",
      "log10 of the classical rate of nucleation [1/(m^3 s)] at the lowest pressure; NaN where "
      "the rate is zero or the card or a dry melt gives none"),
    Q("void_critical_radius", _LINE, "m",
      "critical radius at the lowest pressure; NaN where no bubble can grow or the card gives none",
      shown_in="nm"),
    Q("void_critical_time", _LINE, "s",
      "time to gather a critical bubble's vapor; NaN where no bubble can grow or the card gives "
      "none"),
    Q("void_residence_margin", _LINE, "1",
      "log10 of critical time over time below; NaN where no bubble can grow or the card gives "
      "none"),
    Q("void_required_wetting", _LINE, "1",
      "wetting factor S at which nucleation starts, zero where no bubble can grow; NaN where "
      "the card gives none or the melt is too dry for the threshold"),
    Q("void_required_angle", _LINE, "rad",
      "contact angle through the melt at which nucleation starts, pi where no bubble can grow; "
      "NaN where the card gives none or the melt is too dry for the threshold"),
    Q("void_moisture_limit", _LINE, "1",
      "critical moisture of the streamline: below it no bubble can grow; zero under tension; "
      "NaN where no moisture that the polymer can hold suffices"),
    Q("void_exponent", _LINE, "1",
      "growth exponent, integral of max(0, P_V - p)/(4 eta) over time, from the inlet to zone 3, "
      "on a path without zones to its end"),
    Q("void_exponent_error", _LINE, "1",
      "by how much every second point has the exponent otherwise"),
    # The fibers of the initial angles.
    Q("void_fiber_lowest", "streamline initial_angle", "Pa", "lowest absolute pressure on a fiber"),
    Q("void_fiber_time_below", "streamline initial_angle", "s",
      "time of a fiber below the vapor pressure, up to the outlet"),
    Q("void_fiber_exponent", "streamline initial_angle", "1", "growth exponent on a fiber"),
    Q("void_fiber_exponent_error", "streamline initial_angle", "1",
      "by how much every second point has the exponent on a fiber otherwise"),
    Q("void_added_exponent", "streamline", "1",
      "what fibers add: growth exponent on a fiber less that of the melt's own pressure, mean over "
      "the initial angles"),
    # Nuclei; NaN where the card has no diffusivity or no surface tension.
    Q("void_radius", "streamline initial_angle void_station", "m",
      "radius of a bubble at the tip of a fiber", shown_in="µm"),
    Q("void_radius_error", "streamline initial_angle void_station", "1",
      "what the last halving of its steps in time changed of its logarithm"),
    Q("void_radius_rest", "streamline void_station", "m",
      "radius of the same nucleus without a fiber, at the melt's own pressure", shown_in="µm"),
    Q("void_radius_time", "streamline initial_angle void_step", "s", "times of a nucleus"),
    Q("void_radius_along", "streamline initial_angle void_step", "m", "its radius at these"),
    Q("void_gas", "streamline void_station", "1",
      "volume of the bubbles at tips over that of melt and fibers, mean over the initial angles"),
    Q("void_gas_rest", "streamline void_station", "1", "the same of nuclei without fibers"),
    # From the bed to the free surface; NaN in a layer of left out streamlines only.
    Q("void_layer_lowest_pressure", _LAYER, "Pa", "lowest absolute pressure of the layer"),
    Q("void_layer_mean_pressure", _LAYER, "Pa",
      "lowest absolute pressure of each streamline, mean by flux over the layer", shown_in="MPa"),
    Q("void_layer_fiber_pressure", "void_selection void_layer", "Pa",
      "lowest absolute pressure on each fiber, mean by flux and over the initial angles"),
    Q("void_layer_time_below", _LAYER, "s", "time below the vapor pressure, mean by flux"),
    Q("void_layer_exponent", _LAYER, "1", "growth exponent, mean by flux"),
    Q("void_layer_fiber_exponent", "void_selection void_layer", "1",
      "growth exponent on each fiber, mean by flux and over the initial angles"),
    Q("void_layer_content", "void_selection void_layer void_station", "1",
      "void content of the layer: share of gas in its volume", shown_in="%"),
    Q("void_layer_content_rest", "void_selection void_layer void_station", "1",
      "void content by the same nuclei without fibers", shown_in="%"),
    Q("void_layer_moisture", _LAYER, "1",
      "critical moisture of the layer; NaN too where no moisture that the polymer can hold "
      "suffices"),
    # The bead in all.
    Q("void_bead_lowest_pressure", _BEAD, "Pa", "lowest absolute pressure; NaN if all left out",
      shown_in="MPa"),
    Q("void_bead_moisture", _BEAD, "1",
      "critical moisture of the bead; NaN where no moisture that the polymer can hold suffices, "
      "or all streamlines are left out"),
    Q("void_bead_mean_moisture", _BEAD, "1",
      "critical moisture of each streamline, mean by flux, saturation where none suffices; NaN "
      "if all are left out"),
    Q("void_bead_share_below", _BEAD, "1", "share of the flux that goes below the vapor pressure"),
    Q("void_bead_exponent", _BEAD, "1", "growth exponent, mean by flux; NaN if all are left out"),
    Q("void_bead_fiber_exponent", "void_selection", "1",
      "growth exponent on each fiber, mean by flux and over the initial angles; NaN if all are "
      "left out"),
    # Speeds and moistures that go together; of melts whose stresses follow a power of the speed.
    Q("void_limit_wider", "void_limit_wider", "1",
      "how many times as wide a nucleus on a fiber becomes, on average"),
    Q("void_limit_speed", "void_limit_speed", "1", "factor on all speeds of the flow"),
    Q("void_limit_moisture", "void_limit_wider void_limit_speed", "1",
      "moisture at which it becomes so wide, up to zone 3; NaN where no moisture that the polymer "
      "can hold suffices, 0 under tension"),
    Q("void_bead_content", "void_selection void_station", "1",
      "void content: share of gas in the volume; NaN if all are left out", shown_in="%"),
    Q("void_bead_content_rest", "void_selection void_station", "1",
      "void content by the same nuclei without fibers; NaN if all are left out", shown_in="%"),
    Q("void_fraction", "", "1",
      "void content of the bead at the end of the swell, of nuclei of the assumed size and "
      "number, but for singular streamlines", title="Void content", shown_in="%", response=True),
    Q("void_fraction_rest", "", "1",
      "what of it the same nuclei have without fibers, at the melt's own pressure",
      title="Void content, melt alone", shown_in="%", response=True),
    Q("void_fraction_tips", "", "1", "what of it fibers add at their tips",
      title="Void content, added by fibers", shown_in="%", response=True),
    Q("severity_melt", "", "1",
      "growth exponent of the melt's own pressure, mean by flux over the streamlines that pass "
      "no sharp corner", title="Severity, melt alone", response=True),
    Q("severity_fibers", "", "1",
      "what fibers add: growth exponent on a fiber less that of the melt's own pressure, mean over "
      "the initial angles and by flux over the streamlines that pass no sharp corner",
      title="Severity, added by fibers", response=True),
    *(Q(f"severity_{of}_error", "", "1",
        "by how much every second point of the streamlines would have it otherwise")
      for of in ("melt", "fibers")),
    Q("void_critical_moisture", "", "1",
      "critical moisture: below it no bubble can grow on a fiber, whatever its direction, wherever "
      "it is but on singular streamlines; NaN, among the responses of a sweep saturation, where no "
      "moisture that the polymer can hold suffices",
      title="Critical moisture, worst fiber", shown_in="%", response=True, derive=_moisture),
    Q("void_critical_moisture_mean", "", "1",
      "critical moisture of the median of randomly entering fibers, mean by flux over the "
      "streamlines but singular ones",
      title="Critical moisture, median fiber", shown_in="%", response=True),
)
# fmt: on
"""What this part stores, by name."""
