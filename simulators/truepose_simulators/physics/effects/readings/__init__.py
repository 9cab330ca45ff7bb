"""Physical effects on single readings."""
