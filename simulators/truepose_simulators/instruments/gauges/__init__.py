"""Boxes of length gauges: the same gauges, whatever protocol speaks for them."""
