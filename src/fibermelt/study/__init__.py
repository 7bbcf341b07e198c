"""Studies: what to run, in which order, and where the results are kept."""
