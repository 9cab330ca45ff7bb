"""Keyence GT2 contact sensors behind a DL-EN1 or DL-RS1A unit."""
