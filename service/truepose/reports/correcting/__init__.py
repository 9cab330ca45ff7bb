"""The report of a corrected file."""
