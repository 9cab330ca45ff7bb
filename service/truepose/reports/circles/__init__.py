"""The report of a single-axis circle test, and its sentences."""
