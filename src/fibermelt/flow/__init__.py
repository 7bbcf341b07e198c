"""The deposition flow: nozzle, free surfaces, streamlines (the paper's section 2.1)."""
