"""Cells, their plant, its database server and workers, killed at random moments."""
