"""Free-surface flows in three dimensions: a strand is a tube whose mesh is mapped."""
