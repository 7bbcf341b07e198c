"""What melts that thin do to the bead and to its fibers."""
