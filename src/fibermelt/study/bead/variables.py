"""The variables of the flow, the fiber's cell and its motion; merged into `study.variables`."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["BEAD_VARIABLES"]

_PATH = "streamline point"
_FIBER = "streamline initial_angle point"
_TABLE = "thinning_rate thinning_phase"
_EXTREME = "streamline initial_angle location kind"

BEAD_VARIABLES: Mapping[str, tuple[str, str, str]] = {
    # The labels of the dimensions.
    "streamline": ("streamline", "1", "number of the streamline, from the left edge"),
    "initial_angle": ("initial_angle", "rad", "angle of the fiber at the inlet"),
    "initial_elevation": ("initial_angle", "rad", "angle out of the plane at the inlet"),
    "zone": ("zone", "1", "1 capillary entrance, 2 nozzle exit, 3 end of the swell region"),
    "location": ("location", "1", "1 above the middle of the capillary, 2 below it; 0 all of it"),
    "kind": ("kind", "1", "min or max of surface pressure less streamline pressure"),
    "quantile": ("quantile", "1", "share of isotropically entering fibers that lie below"),
    # The flow.
    "node_x": ("node", "m", "x of the flow's nodes, from the nozzle's axis"),
    "node_y": ("node", "m", "y of the flow's nodes, from the bed"),
    "node_velocity": ("node component", "m/s", "velocity"),
    "node_pressure": ("node", "Pa", "pressure above the surrounding air's"),
    "node_gradient": ("node row column", "1/s", "velocity gradient L_ij = du_i/dx_j"),
    "node_stream_function": ("node", "m^2/s", "stream function"),
    "node_viscosity": ("node", "Pa s", "viscosity of the melt at its rate of deformation"),
    "node_gradient_error": ("node", "1/s", "estimated error of the velocity gradient"),
    "cell_nodes": ("cell local", "1", "nodes of each flow triangle, in the order of VTK"),
    "field_order": ("", "1", "polynomial order of the flow triangles"),
    "upstream_surface": ("upstream_point component", "m", "free surface, upstream lip to contact"),
    "downstream_surface": (
        "downstream_point component",
        "m",
        "free surface, downstream lip to outlet",
    ),
    "bead_height": ("", "m", "height of the bead at the outlet"),
    "inlet_pressure": ("", "Pa", "pressure at the inlet above the surrounding air's"),
    "contact_point": ("", "m", "x where the upstream free surface meets the bed"),
    "heel": ("", "m", "x of the melt's foremost point upstream"),
    "contact_point_error": ("", "m", "estimated error of the contact point"),
    "heel_error": ("", "m", "estimated error of the heel"),
    "inlet_pressure_error": ("", "Pa", "estimated error of the inlet pressure"),
    "mass_imbalance": ("", "1", "flux error at the outlet, relative to the inlet's"),
    "kinematic_residual": (
        "",
        "1",
        "root mean square of u.n over the free surfaces, in bed speeds",
    ),
    "newton_steps": ("", "1", "Newton steps of the flow, all meshes together"),
    "unknowns": ("", "1", "unknowns of the flow on the last mesh"),
    "elements": ("", "1", "triangles of the last mesh"),
    # The streamlines.
    "time": (_PATH, "s", "time since the inlet"),
    "x": (_PATH, "m", "x along the streamline, from the nozzle's axis"),
    "y": (_PATH, "m", "y along the streamline, from the bed"),
    "u": (_PATH, "m/s", "velocity along x"),
    "v": (_PATH, "m/s", "velocity along y"),
    "z": (_PATH, "m", "z along the streamline"),
    "w": (_PATH, "m/s", "velocity along z"),
    "pressure": (_PATH, "Pa", "pressure of the melt above the surrounding air's"),
    "shear_rate": (_PATH, "1/s", "scalar rate of deformation sqrt(2 D:D)"),
    "viscosity": (_PATH, "Pa s", "viscosity of the melt at its rate of deformation"),
    "stream_function": (_PATH, "m^2/s", "stream function along the streamline"),
    "gradient": (f"{_PATH} row column", "1/s", "velocity gradient L_ij = du_i/dx_j"),
    "flux_fraction": ("streamline", "1", "share of the flux on the streamline's left"),
    "gradient_error": (_PATH, "1/s", "estimated error of the gradient along the streamline"),
    "stream_function_drift": ("streamline", "1", "drift of the stream function over the flux"),
    "near_singularity": ("streamline", "1", "whether it passes close by a singular corner"),
    "zone_time": ("streamline zone", "s", "time at which the zone is reached"),
    "middle_time": ("streamline", "s", "time at the middle of the capillary"),
    "law_rate": ("law_point", "1/s", "rates of deformation at which the melt's law is drawn"),
    "law_viscosity": ("law_point", "Pa s", "viscosity of the melt at them"),
    # The fiber's cell.
    "fiber_model": ("", "1", "what answers for the fiber"),
    "aspect_ratio": ("", "1", "length over width of the fiber"),
    "domain_size": ("", "1", "domain-size factor M; NaN if unbounded"),
    "shape_factor": ("", "1", "shape factor B; Jeffery's xi if unbounded"),
    "stall_angle": ("", "rad", "angle to simple shear at which it stalls; NaN if it tumbles"),
    "tip_pressure": ("", "1", "largest surface pressure in simple shear over mu gamma_dot"),
    "shape_factor_error": ("", "1", "estimated absolute error of the shape factor"),
    "tip_pressure_error": ("", "1", "estimated relative error of the tip pressure"),
    "cell_unknowns": ("", "1", "unknowns of the cell"),
    "surface_angle": ("surface", "rad", "eccentric angle on the fiber's surface"),
    "surface_basis": ("surface mode", "1", "surface pressure over mu D_11 and mu D_12"),
    "cell_point": ("cell_node component", "1", "nodes around the fiber, over its half-length"),
    "cell_triangle": ("cell_element corner", "1", "triangles to draw the cell with"),
    "cell_edge": ("cell_line cell_place", "1", "nodes along the curved edges of the elements"),
    "cell_velocity": ("cell_node mode component", "1", "velocity of the basis solutions"),
    "cell_pressure": ("cell_node mode", "1", "pressure of the basis solutions"),
    # The fiber in a melt that thins.
    "thinning_aspect_ratio": ("", "1", "length over width of the fiber of the table"),
    "thinning_rate": ("thinning_rate", "1/s", "rates of deformation of the far field"),
    "thinning_spin": (
        "thinning_rate thinning_term",
        "1",
        "spin over half the rate: terms in sin (2k + 1) phi, phi twice the angle to the stretch",
    ),
    "thinning_lowest": (_TABLE, "1", "lowest surface pressure over eta times half the rate"),
    "thinning_highest": (_TABLE, "1", "highest surface pressure over eta times half the rate"),
    "thinning_where_lowest": (_TABLE, "rad", "eccentric angle of the lowest pressure"),
    "thinning_where_highest": (_TABLE, "rad", "eccentric angle of the highest pressure"),
    "thinning_tip": (_TABLE, "1", "pressure at the tip over eta times half the rate"),
    "thinning_surface": ("thinning_surface", "rad", "eccentric angles of the surface's points"),
    "thinning_pressure": (
        "thinning_rate thinning_direction thinning_surface",
        "1",
        "surface pressure over eta times half the rate, at the directions that were solved for",
    ),
    "thinning_spin_error": ("", "1", "estimated error of the spin over half the rate"),
    "thinning_pressure_error": ("", "1", "estimated error of the extremes over the largest"),
    # The fibers along the streamlines.
    "angle": (_FIBER, "rad", "angle of the fiber from the x axis"),
    "elevation": (_FIBER, "rad", "angle of the fiber out of the plane of the flow"),
    "lowest": (_FIBER, "Pa", "lowest surface pressure less streamline pressure"),
    "highest": (_FIBER, "Pa", "highest surface pressure less streamline pressure"),
    "bound_lowest": (_PATH, "Pa", "lowest surface pressure over every orientation"),
    "bound_highest": (_PATH, "Pa", "highest surface pressure over every orientation"),
    "quantile_lowest": (f"{_PATH} quantile", "Pa", "lowest pressure of isotropic fibers"),
    "quantile_highest": (f"{_PATH} quantile", "Pa", "highest pressure of isotropic fibers"),
    "extreme": (_EXTREME, "Pa", "extreme of surface pressure less streamline pressure"),
    "extreme_x": (_EXTREME, "m", "x of the extreme"),
    "extreme_y": (_EXTREME, "m", "y of the extreme"),
    "extreme_z": (_EXTREME, "m", "z of the extreme"),
    "extreme_error": (_EXTREME, "Pa", "estimated error of the extreme, by the points' spacing"),
    "extreme_time": (_EXTREME, "s", "time of the extreme"),
    "extreme_pressure": (_EXTREME, "Pa", "pressure at the extreme above the surrounding air's"),
    "extreme_angle": (_EXTREME, "rad", "angle of the fiber to the streamline at the extreme"),
    "extreme_where": (_EXTREME, "rad", "eccentric angle of the extreme on the surface"),
    "extreme_bounds": (
        "streamline location kind side",
        "Pa",
        "bounds of the extreme over every orientation",
    ),
    "extreme_quantiles": (
        "streamline location kind quantile",
        "Pa",
        "quantiles of the extreme for an isotropic start",
    ),
    "zone_angle": (
        "streamline initial_angle zone",
        "rad",
        "angle of the fiber to the streamline at the zone",
    ),
}
"""``{name: (dimensions, unit, long name)}``, as `fibermelt.study.variables.VARIABLES`."""
