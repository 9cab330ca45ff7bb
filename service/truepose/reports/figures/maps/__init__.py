"""Figures over a plane or two names: errors in space, shifts, causes, correlations."""
