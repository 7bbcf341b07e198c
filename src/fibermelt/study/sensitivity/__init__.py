"""Single fibers in simple shear, and ellipses against the spheroids that they stand for."""
