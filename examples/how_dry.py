"""
How dry the pellets must be
===========================

Moisture in the melt has a vapor pressure. Where the pressure, on a fiber or between fibers, is
below it, a bubble can grow. The critical moisture is that at which both are equal; under tension
there is none, and no drying helps.
"""

import matplotlib.pyplot as plt
import numpy as np

from fibermelt.parts.melt.cards import load_card
from fibermelt.voids import ATMOSPHERE, saturation_pressure

card = load_card("paper")  # the paper's melt; every value has its source, or is an estimate
temperature = card.temperature  # 230 degC, in K
vapor = float(card.melt.vapor_pressure(card.moisture, temperature))
print(
    f"{card.moisture:.2%} of moisture: {vapor / 1e6:.3f} MPa; "
    f"free water: {float(saturation_pressure(temperature)) / 1e6:.3f} MPa"
)

lowest = np.array([-0.5e6, 0.0, 0.5 * ATMOSPHERE, ATMOSPHERE, 1e6])  # absolute
critical = card.melt.critical_moisture(lowest, temperature)
for pressure, moisture in zip(lowest, critical, strict=True):
    remedy = f"dry below {moisture:.3%}" if moisture > 0 else "no drying helps"
    print(f"lowest pressure {pressure / 1e6:6.3f} MPa: {remedy}")

# %%
# The hotter the melt, the drier it must be.

pressures = np.linspace(0.0, 0.5e6, 101)
figure, axes = plt.subplots(layout="constrained")
for celsius in (200, 230, 260):
    moisture = card.melt.critical_moisture(pressures, celsius + 273.15)
    axes.plot(pressures / 1e6, 100 * moisture, label=f"{celsius} degC")
axes.axhline(100 * card.moisture, color="k", ls="--", label="as received")
axes.set(xlabel="lowest local pressure, absolute [MPa]", ylabel="critical moisture [wt%]")
axes.legend()
plt.show()
