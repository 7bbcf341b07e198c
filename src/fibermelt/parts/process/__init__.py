"""Inputs of the trade: nozzle, layer, bead, speed and flow, and the planar study that they give."""
