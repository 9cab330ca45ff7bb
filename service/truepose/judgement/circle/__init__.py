"""The single-axis circle test: one joint turns, all others stand, a nest runs on a circle."""
