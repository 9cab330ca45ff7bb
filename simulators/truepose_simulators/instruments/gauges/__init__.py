"""Gauges of length, the ballbar among them, and the boxes and cables that speak for them."""
