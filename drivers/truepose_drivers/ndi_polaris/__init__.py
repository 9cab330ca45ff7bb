"""Optical trackers of poses that speak NDI's combined API (Polaris, Vega) over TCP or a serial line."""
