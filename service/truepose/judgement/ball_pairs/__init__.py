"""Whether a reading, or all readings of a pose, go with the pairs of cup and nest that were asked for."""
