"""What thinning does to a bead and its fibers: one melt's laws of falling index, side by side."""
