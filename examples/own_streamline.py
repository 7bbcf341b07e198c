"""
A fiber in a flow of your own
=============================

All that a fiber needs is the history of the melt around it: time, position, velocity, velocity
gradient and pressure. Any other solver, a measurement or, as here, a formula can give one. Here the
melt is stretched at a constant rate, as on the axis of a converging channel: everything is known.
"""

import matplotlib.pyplot as plt
import numpy as np

import fibermelt as fm

rate, viscosity = 2.0, 817.0  # 1/s, Pa s
time = np.linspace(0.0, 2.0, 401)
position = np.stack([1e-3 * np.exp(rate * time), 1e-3 * np.exp(-rate * time)], axis=-1)
gradient = np.broadcast_to(np.diag([rate, -rate]), (time.size, 2, 2))
history = fm.FlowHistory(
    time=time,
    position=position,
    velocity=np.einsum("nij,nj->ni", gradient, position),
    gradient=gradient,
    pressure=np.zeros_like(time),  # above the air's
)

response = fm.unbounded_model("ellipse", fm.Ellipse(42e-6, aspect_ratio=6.0)).response
start = np.radians([20.0, 50.0, 80.0, 89.0])
motion = fm.follow(history, response.shape_factor, start)
pressure = fm.surface_pressure(history, response, viscosity, motion)

# %%
# In this flow ``tan(theta)`` falls like ``exp(-2 xi rate t)``, with Jeffery's shape factor ``xi``;
# once the fiber lies along the flow its tips see ``-2 mu rate (1 + r_e)``.

exact = np.arctan(np.tan(start)[:, None] * np.exp(-2 * response.shape_factor * rate * time))
deepest = -2 * viscosity * rate * (1 + 6.0)
print(f"angles are off by {np.abs(motion.angle - exact).max():.0e} rad")
print(f"at the end {pressure.lowest[0, -1] / 1e3:.3f} kPa, aligned {deepest / 1e3:.3f} kPa")

figure, (above, below) = plt.subplots(2, sharex=True, layout="constrained")
above.plot(time, np.degrees(motion.angle.T))
above.set(ylabel="angle [deg]")
below.plot(time, pressure.lowest.T / 1e3)
below.axhline(deepest / 1e3, color="k", ls="--", label="aligned, exactly")
below.set(xlabel="time [s]", ylabel="lowest pressure [kPa]")
below.legend()
plt.show()
