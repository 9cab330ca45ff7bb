"""Identified models in the forms of other programs: one file a format, registered in `formats`."""
