"""Digimatic gauges on a Mitutoyo multiplexer or serial input tool."""
