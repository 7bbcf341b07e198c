"""Where in the bead voids can start."""
