"""People: their names, and who may ask for what."""
