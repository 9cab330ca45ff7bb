"""The report of a diagnosis: its findings, the map of causes, and what was ruled out."""
