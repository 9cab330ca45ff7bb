"""Measuring with a tracker: following the reflector, tool nests, groups of readings."""
