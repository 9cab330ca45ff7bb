"""Instrument and robot drivers: what a device offers, and how each protocol provides it."""
