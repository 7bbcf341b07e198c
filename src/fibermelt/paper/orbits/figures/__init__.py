"""Figures of one fiber in simple shear."""
