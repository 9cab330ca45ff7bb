"""Files that somebody brings as they are: what stands in them is guessed, shown, and only then read."""
