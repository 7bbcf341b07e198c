"""Orientation tensors along the paths."""
