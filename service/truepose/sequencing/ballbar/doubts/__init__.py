"""Whether a length goes with the pair that was asked for."""
