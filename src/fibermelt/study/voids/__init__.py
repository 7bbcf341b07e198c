"""Stages, settings and summary of voids: vapor against the pressure of the melt."""
