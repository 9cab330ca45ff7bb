"""The night run: which cases it has, what they must reach, and the table of a night."""
