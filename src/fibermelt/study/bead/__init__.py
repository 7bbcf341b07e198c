"""Stages and summary of fibers in the bead: flow, streamlines, cell, motion."""
