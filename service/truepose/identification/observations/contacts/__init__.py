"""Closed loops as observations: one file for each thing that readings are taken against."""
