"""Figures of voids."""
