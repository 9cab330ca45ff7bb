"""Gauges behind Mitutoyo's EH and EV counters, and ID-H indicators."""
