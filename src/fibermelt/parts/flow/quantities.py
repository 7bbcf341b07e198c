"""What is stored of the flow and of the streamlines through it."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity, declared

__all__ = ["QUANTITIES"]

_PATH = "streamline point"

QUANTITIES = declared(
    # The labels of the dimensions.
    Quantity(
        "streamline",
        "streamline",
        "1",
        "number of the streamline, from the left edge",
        swept="kept",
    ),
    Quantity(
        "zone",
        "zone",
        "1",
        "1 capillary entrance, 2 nozzle exit, 3 end of the swell region",
        swept="kept",
    ),
    # The flow.
    Quantity("node_x", "node", "m", "x of the flow's nodes, from the nozzle's axis"),
    Quantity("node_y", "node", "m", "y of the flow's nodes, from the bed"),
    Quantity("node_velocity", "node component", "m/s", "velocity"),
    Quantity("node_pressure", "node", "Pa", "pressure above the surrounding air's"),
    Quantity(
        "node_gradient",
        "node row column",
        "1/s",
        "velocity gradient L_ij = du_i/dx_j",
        error="node_gradient_error",
    ),
    Quantity("node_stream_function", "node", "m^2/s", "stream function"),
    Quantity("node_viscosity", "node", "Pa s", "viscosity of the melt at its rate of deformation"),
    Quantity("node_gradient_error", "node", "1/s", "estimated error of the velocity gradient"),
    Quantity("cell_nodes", "cell local", "1", "nodes of each flow triangle, in the order of VTK"),
    Quantity("field_order", "", "1", "polynomial order of the flow triangles", response=False),
    Quantity(
        "upstream_surface", "upstream_point component", "m", "free surface, upstream lip to contact"
    ),
    Quantity(
        "downstream_surface",
        "downstream_point component",
        "m",
        "free surface, downstream lip to outlet",
    ),
    Quantity(
        "contact_point",
        "",
        "m",
        "x where the upstream surface meets the bed, from the nozzle's axis",
        title="Contact point",
        shown_in="mm",
        error="contact_point_error",
        response=True,
    ),
    Quantity(
        "inlet_pressure",
        "",
        "Pa",
        "mean pressure over the inlet, above the surrounding air's",
        title="Inlet pressure",
        shown_in="MPa",
        error="inlet_pressure_error",
        response=True,
    ),
    Quantity(
        "bead_height",
        "",
        "m",
        "height of the bead at the outlet",
        title="Bead height",
        shown_in="mm",
        response=True,
    ),
    Quantity(
        "heel",
        "",
        "m",
        "x of the melt's foremost point upstream, from the nozzle's axis",
        title="Heel",
        shown_in="mm",
        error="heel_error",
    ),
    Quantity(
        "mass_imbalance",
        "",
        "1",
        "flux error at the outlet, relative to the inlet's",
        title="Mass imbalance",
        response=False,
    ),
    Quantity(
        "kinematic_residual",
        "",
        "1",
        "root mean square of u.n over the free surfaces, in bed speeds",
        title="Kinematic residual",
        response=False,
    ),
    Quantity(
        "newton_steps",
        "",
        "1",
        "Newton steps of the flow, all meshes together",
        title="Newton steps",
        response=False,
    ),
    Quantity(
        "unknowns",
        "",
        "1",
        "unknowns of the flow on the last mesh",
        title="Unknowns",
        response=False,
    ),
    Quantity("elements", "", "1", "triangles of the last mesh", title="Triangles", response=False),
    Quantity("contact_point_error", "", "m", "estimated error of the contact point"),
    Quantity("inlet_pressure_error", "", "Pa", "estimated error of the inlet pressure"),
    Quantity("heel_error", "", "m", "estimated error of the heel"),
    # The field of another solver.
    Quantity("field_geometry", "", "1", "planar, axisymmetric or spatial"),
    Quantity("field_notes", "", "1", "what was done to the file's data"),
    Quantity("field_points", "field_node space", "m", "nodes of the field"),
    Quantity(
        "field_cells", "field_cell field_corner", "1", "nodes of each triangle or tetrahedron"
    ),
    Quantity("field_velocity", "field_node space", "m/s", "velocity"),
    Quantity(
        "field_gradient",
        "field_node space other_space",
        "1/s",
        "velocity gradient du_i/dx_j",
        error="field_gradient_error",
    ),
    Quantity(
        "field_gradient_error", "field_node", "1/s", "estimated error of the velocity gradient"
    ),
    Quantity("field_divergence", "field_node", "1/s", "trace that was taken out of the gradient"),
    Quantity("field_pressure", "field_node", "Pa", "pressure above the surrounding air's"),
    Quantity("field_viscosity", "field_node", "Pa s", "viscosity that the file has"),
    Quantity("field_temperature", "field_node", "K", "temperature"),
    Quantity(
        "field_near_wall", "field_node", "1", "whether the gradient is one-sided or near an edge"
    ),
    Quantity("field_near_edge", "field_node", "1", "whether a sharp edge is near"),
    Quantity("field_cut", "field_node", "1", "whether the file has no numbers beyond"),
    # The streamlines.
    Quantity("time", _PATH, "s", "time since the inlet"),
    Quantity("x", _PATH, "m", "x along the streamline, from the nozzle's axis"),
    Quantity("y", _PATH, "m", "y along the streamline, from the bed"),
    Quantity("u", _PATH, "m/s", "velocity along x"),
    Quantity("v", _PATH, "m/s", "velocity along y"),
    Quantity("z", _PATH, "m", "z along the streamline"),
    Quantity("w", _PATH, "m/s", "velocity along z"),
    Quantity("pressure", _PATH, "Pa", "pressure of the melt above the surrounding air's"),
    Quantity("shear_rate", _PATH, "1/s", "scalar rate of deformation sqrt(2 D:D)"),
    Quantity("viscosity", _PATH, "Pa s", "viscosity of the melt at its rate of deformation"),
    Quantity("stream_function", _PATH, "m^2/s", "stream function along the streamline"),
    Quantity(
        "gradient",
        f"{_PATH} row column",
        "1/s",
        "velocity gradient L_ij = du_i/dx_j",
        error="gradient_error",
    ),
    Quantity(
        "flux_fraction",
        "streamline",
        "1",
        "share of the flux on the streamline's left; of the paths where they stand for none",
    ),
    Quantity(
        "gradient_error", _PATH, "1/s", "estimated error of the gradient along the streamline"
    ),
    Quantity(
        "stream_function_drift", "streamline", "1", "drift of the stream function over the flux"
    ),
    Quantity("near_singularity", "streamline", "1", "whether it passes close by a singular corner"),
    Quantity("zone_time", "streamline zone", "s", "time at which the zone is reached"),
    Quantity("middle_time", "streamline", "s", "time at the middle of the capillary"),
    Quantity("temperature", _PATH, "K", "temperature of the melt"),
    Quantity(
        "path_end", "streamline", "1", "why the path ends: outlet, wall, stagnation, time or file"
    ),
    Quantity(
        "path_divergence",
        "streamline",
        "1",
        "largest trace that was taken out of the gradient, over the largest gradient",
    ),
    Quantity(
        "path_consistency",
        "streamline",
        "1",
        "what dx/dt = u or du/dt = L u misses, over the way or the velocity's changes",
    ),
    Quantity("path_coarseness", "streamline", "1", "what every second point misses of the strain"),
    Quantity("path_notes", "streamline", "1", "what does not fit along the path"),
    Quantity(
        "law_rate", "law_point", "1/s", "rates of deformation at which the melt's law is drawn"
    ),
    Quantity("law_viscosity", "law_point", "Pa s", "viscosity of the melt at them"),
)
"""What this part stores, by name."""
