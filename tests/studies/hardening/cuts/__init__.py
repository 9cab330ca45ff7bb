"""A tablet's network is cut while somebody taps."""
