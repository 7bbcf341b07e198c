"""What is stored of the flow and of the streamlines through it."""

from __future__ import annotations

from fibermelt.engine.quantities import Quantity as Q
from fibermelt.engine.quantities import declared

__all__ = ["QUANTITIES"]

_PATH = "streamline point"

# fmt: off
QUANTITIES = declared(
    # The labels of the dimensions.
    Q("streamline", "streamline", "1", "number of the streamline, from the upstream edge",
      swept="kept"),
    Q("zone", "zone", "1", "1 capillary entrance, 2 nozzle exit, 3 end of the swell region",
      swept="kept"),
    # The flow.
    Q("node_x", "node", "m", "x of the flow's nodes, from the nozzle's axis"),
    Q("node_y", "node", "m", "y of the flow's nodes, from the bed"),
    Q("node_velocity", "node component", "m/s", "velocity"),
    Q("node_pressure", "node", "Pa", "pressure above the surrounding air's"),
    Q("node_gradient", "node row column", "1/s", "velocity gradient L_ij = du_i/dx_j"),
    Q("node_stream_function", "node", "m^2/s", "stream function"),
    Q("node_viscosity", "node", "Pa s", "viscosity of the melt at its rate of deformation"),
    Q("node_gradient_error", "node", "1/s", "estimated error of the velocity gradient"),
    Q("cell_nodes", "cell local", "1", "nodes of each flow triangle, in the order of VTK"),
    Q("field_order", "", "1", "polynomial order of the flow triangles", response=False),
    Q("upstream_surface", "upstream_point component", "m", "free surface, upstream lip to contact"),
    Q("downstream_surface", "downstream_point component", "m",
      "free surface, downstream lip to outlet"),
    Q("contact_point", "", "m",
      "x where the upstream surface meets the bed, from the nozzle's axis", title="Contact point",
      shown_in="mm", response=True),
    Q("inlet_pressure", "", "Pa", "mean pressure over the inlet, above the surrounding air's",
      title="Inlet pressure", shown_in="MPa", response=True),
    Q("bead_height", "", "m", "height of the bead at the outlet", title="Bead height",
      shown_in="mm", response=True),
    Q("heel", "", "m", "x of the melt's foremost point upstream, from the nozzle's axis",
      title="Heel", shown_in="mm"),
    Q("mass_imbalance", "", "1", "flux error at the outlet, relative to the inlet's",
      title="Mass imbalance", response=False),
    Q("kinematic_residual", "", "1",
      "root mean square of u.n over the free surfaces, in bed speeds", title="Kinematic residual",
      response=False),
    Q("newton_steps", "", "1", "Newton steps of the flow, all meshes together",
      title="Newton steps", response=False),
    Q("unknowns", "", "1", "unknowns of the flow on the last mesh", title="Unknowns",
      response=False),
    Q("elements", "", "1", "triangles of the last mesh", title="Triangles", response=False),
    Q("contact_point_error", "", "m", "estimated error of the contact point"),
    Q("inlet_pressure_error", "", "Pa", "estimated error of the inlet pressure"),
    Q("heel_error", "", "m", "estimated error of the heel"),
    # The field of another solver.
    Q("field_geometry", "", "1", "planar, axisymmetric or spatial"),
    Q("field_notes", "", "1", "what was done to the file's data"),
    Q("field_points", "field_node space", "m", "nodes of the field"),
    Q("field_cells", "field_cell field_corner", "1", "nodes of each triangle or tetrahedron"),
    Q("field_velocity", "field_node space", "m/s", "velocity"),
    Q("field_gradient", "field_node space other_space", "1/s", "velocity gradient du_i/dx_j"),
    Q("field_gradient_error", "field_node", "1/s", "estimated error of the velocity gradient"),
    Q("field_divergence", "field_node", "1/s", "trace that was taken out of the gradient"),
    Q("field_pressure", "field_node", "Pa", "pressure above the surrounding air's"),
    Q("field_viscosity", "field_node", "Pa s", "viscosity that the file has"),
    Q("field_temperature", "field_node", "K", "temperature"),
    Q("field_near_wall", "field_node", "1", "whether the gradient is one-sided or near an edge"),
    Q("field_near_edge", "field_node", "1", "whether a sharp edge is near"),
    Q("field_cut", "field_node", "1", "whether the file has no numbers beyond"),
    # The streamlines.
    Q("time", _PATH, "s", "time since the inlet"),
    Q("x", _PATH, "m", "x along the streamline, from the nozzle's axis"),
    Q("y", _PATH, "m", "y along the streamline, from the bed"),
    Q("u", _PATH, "m/s", "velocity along x"),
    Q("v", _PATH, "m/s", "velocity along y"),
    Q("z", _PATH, "m", "z along the streamline"),
    Q("w", _PATH, "m/s", "velocity along z"),
    Q("pressure", _PATH, "Pa", "pressure of the melt above the surrounding air's"),
    Q("shear_rate", _PATH, "1/s", "scalar rate of deformation sqrt(2 D:D)"),
    Q("viscosity", _PATH, "Pa s", "viscosity of the melt at its rate of deformation"),
    Q("stream_function", _PATH, "m^2/s", "stream function along the streamline"),
    Q("gradient", f"{_PATH} row column", "1/s", "velocity gradient L_ij = du_i/dx_j"),
    Q("flux_fraction", "streamline", "1",
      "share of the flux on the streamline's left; of the paths where they stand for none"),
    Q("gradient_error", _PATH, "1/s", "estimated error of the gradient along the streamline"),
    Q("stream_function_drift", "streamline", "1", "drift of the stream function over the flux"),
    Q("corner_distance", _PATH, "m", "distance from the nearest sharp corner"),
    Q("near_singularity", "streamline", "1", "whether it passes close by a sharp corner"),
    Q("zone_time", "streamline zone", "s", "time at which the zone is reached; NaN if never"),
    Q("temperature", _PATH, "K", "temperature of the melt"),
    Q("path_end", "streamline", "1", "why the path ends: outlet, wall, stagnation, time or file"),
    Q("path_divergence", "streamline", "1",
      "largest trace that was taken out of the gradient, over the largest gradient"),
    Q("path_consistency", "streamline", "1",
      "what dx/dt = u or du/dt = L u misses, over the way or the velocity's changes"),
    Q("path_coarseness", "streamline", "1", "what every second point misses of the strain"),
    Q("path_notes", "streamline", "1", "what does not fit along the path"),
)
# fmt: on
"""What this part stores, by name."""
