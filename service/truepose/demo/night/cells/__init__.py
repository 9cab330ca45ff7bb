"""Cells that are calibrated in a night, each by another instrument, and judged."""
