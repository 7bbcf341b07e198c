"""The planar answer beside a bead in space: what a slot gets right of it, and what not."""
