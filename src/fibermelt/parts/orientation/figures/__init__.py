"""Figures of orientation tensors along the paths."""
