"""Short text tables for a terminal: what the first screen of a report says."""
