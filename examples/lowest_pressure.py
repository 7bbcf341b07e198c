"""
The lowest pressure on a fiber
==============================

From a nozzle to the lowest pressure that a fiber makes on its own surface, as the paper goes: the
deposition flow, one of its streamlines, a fiber in its cell, how it turns, what its surface sees.
"""

import matplotlib.pyplot as plt

import fibermelt as fm

problem = fm.Deposition(fm.Nozzle(gap=3e-3), fm.Newtonian(viscosity=817.0))  # Fig. 1-2, Eq. 1-4
flow = fm.solve_deposition(problem)
line = fm.trace_streamlines(flow, count=22)[9]  # the paper's psi_10
fiber = fm.Ellipse(half_length=42e-6, aspect_ratio=6.0)
cell = fm.solve_cell(fiber, domain_size=4.0)  # Fig. 5-6
motion = fm.follow(line.history, cell.shape_factor, fm.paper_angles())
pressure = fm.surface_pressure(line.history, cell.response, problem.melt.viscosity, motion)
found = fm.extremes(line.history, pressure, motion, line.zone_time)  # Fig. 16-19
lowest = found.pressure[..., 1:, 0].min(axis=0)  # over the 13 initial angles, at Loc. 1 and Loc. 2
print(
    f"lowest pressure on the fiber: {lowest[0] / 1e6:.2f} MPa in the nozzle, "
    f"{lowest[1] / 1e6:.2f} MPa in the bead"
)

# %%
# The pressure is zero in the air. Each gray line is a fiber that entered at another angle; no
# fiber, at whatever angle, can go below the bound, which samples no angle.

bound = fm.pressure_bounds(line.history, cell.response, problem.melt.viscosity)
own = line.history.pressure / 1e6
figure, axes = plt.subplots(layout="constrained")
axes.plot(line.history.time, (own + pressure.lowest / 1e6).T, color="0.7", lw=0.8)
axes.plot(line.history.time, own + bound.lowest / 1e6, "k--", label="bound over every direction")
axes.plot(line.history.time, own, label="the melt's own")
for zone in line.zone_time:
    axes.axvline(zone, color="0.5", ls=":")  # the capillary, from 1 to 2, and the swell, to 3
axes.set(xlabel="time since the inlet [s]", ylabel="pressure above the air's [MPa]")
axes.legend()
plt.show()
