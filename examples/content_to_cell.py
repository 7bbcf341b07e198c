"""From fiber content to the size of the cell that stands for it (the paper's section 2.5)."""

import fibermelt as fm
from fibermelt.orientation.interaction import bay

content, aspect_ratio = 0.084, 6.0
interaction = bay(content, aspect_ratio)  # C_I
shear = [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
xi = fm.unbounded_model("ellipse", fm.Ellipse(42e-6, aspect_ratio)).response.shape_factor

curve = fm.stall_curve(aspect_ratio)  # B(M) from a dozen cells, Fig. 14c
sizes = {}
for convention in ("standard", "paper"):
    model = fm.FolgarTucker(xi, interaction, convention=convention)  # Eq. 26
    steady = fm.steady_state(model, shear, fm.closure("ORE"))  # Eq. 27-28
    sizes[convention] = curve.domain_size_at(steady.angle)  # Fig. 15
    print(
        f"{convention:9} C_I = {interaction:.4f}: fibers lie at {steady.angle:.4f} rad, "
        f"a fiber stalls there in a cell of M = {sizes[convention]:.3f}"
    )
