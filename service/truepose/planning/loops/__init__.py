"""Stops of closed loops, and the accuracy that they promise."""
