"""Effects of single readings: labels that were swapped, readings that belong to no model."""
