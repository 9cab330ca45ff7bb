"""Figures of how many: errors, distances, two models in the same bins."""
