"""What is stored of two dimensions against three."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared

__all__ = ["QUANTITIES"]

_FEATURE = "feature dimension_model"

# fmt: off
QUANTITIES = declared(
    Q("dimension_model", "dimension_model", "1", "what answers for the fiber"),
    Q("dimension_domain_size", "", "1", "domain-size factor M of the confined ellipses"),
    Q("unbounded_model", "unbounded_model", "1", "closed form"),
    Q("peak_ratio", "peak", "1", "aspect ratio"),
    Q("peak_pressure", "unbounded_model peak", "1", "highest pressure in shear over mu gamma_dot"),
    Q("peak_at_ratio", "dimension_model ratio", "1", "highest pressure in shear over mu gamma_dot"),
    Q("planar_angle", "planar_angle", "rad", "angle of the fiber at the inlet, in the plane"),
    Q("feature_streamline", "feature", "1", "number of the streamline, from the upstream edge"),
    Q("feature_time", "feature point", "s", "time since the inlet"),
    Q("feature_zone_time", "feature zone", "s", "time at which the zone is reached"),
    Q("feature_bound", f"{_FEATURE} point", "Pa", "lowest pressure over every orientation"),
    Q("feature_lowest", f"{_FEATURE} point", "Pa", "lowest pressure over the initial angles"),
    Q("feature_extreme", f"{_FEATURE} planar_angle location", "Pa",
      "lowest pressure on the way of each initial angle"),
    Q("feature_extreme_bound", f"{_FEATURE} location", "Pa",
      "lowest pressure on the way over every orientation"),
)
# fmt: on
"""What this part stores, by name; beside the labels ``ratio``, ``zone`` and
``location`` of others."""
