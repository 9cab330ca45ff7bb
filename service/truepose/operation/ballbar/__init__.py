"""Ballbar sessions under way: planned, run, shown, and what counts of them."""
