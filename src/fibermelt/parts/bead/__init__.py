"""Fibers along the paths of a flow, and the pressure on them."""
