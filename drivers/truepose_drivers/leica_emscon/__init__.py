"""Leica laser trackers that speak emScon over TCP (AT40x, AT901, LTD)."""
