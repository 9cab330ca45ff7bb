"""Identified models as files."""
