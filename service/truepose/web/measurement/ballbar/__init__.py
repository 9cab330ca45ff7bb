"""Ballbar sessions as REST resources: planned, acted upon, followed live."""
