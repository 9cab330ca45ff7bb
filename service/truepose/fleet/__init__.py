"""Fleets: what robots of one type share, what is each one's own, what changes over months; all is pure."""
