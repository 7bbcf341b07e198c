"""Figures of the flow and of its streamlines."""
