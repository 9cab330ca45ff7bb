"""How a reader sees names and numbers: causes in words, rounding, turns."""
