"""Trackers that only their maker's software can drive, by way of a small program beside it."""
