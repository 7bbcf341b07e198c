"""From a nozzle to the lowest pressure that a fiber makes on its own surface."""

import fibermelt as fm

problem = fm.Deposition(fm.Nozzle(gap=3e-3), fm.Newtonian(viscosity=817.0))  # Fig. 1-2, Eq. 1-4
flow = fm.solve_deposition(problem)
line = fm.trace_streamlines(flow, count=22)[9]  # the paper's psi_10
fiber = fm.Ellipse(half_length=42e-6, aspect_ratio=6.0)
cell = fm.solve_cell(fiber, domain_size=4.0)  # Fig. 5-6
motion = fm.follow(line.history, cell.shape_factor, fm.paper_angles())
pressure = fm.surface_pressure(line.history, cell.response, problem.melt.viscosity, motion)
found = fm.extremes(line.history, pressure, motion, line.middle_time)  # Fig. 16-19
lowest = found.pressure[..., 0].min(axis=0)  # over the 13 initial angles, at Loc. 1 and Loc. 2
print(
    f"lowest pressure on the fiber: {lowest[0] / 1e6:.2f} MPa in the nozzle, "
    f"{lowest[1] / 1e6:.2f} MPa in the bead"
)
