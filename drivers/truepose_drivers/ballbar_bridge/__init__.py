"""Ballbars that only their maker's software can read, by way of a small program beside it."""
