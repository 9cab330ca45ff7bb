"""Digimatic gauges on a Mitutoyo USB-ITN cable."""
