"""Figures of the fibers along the paths."""
