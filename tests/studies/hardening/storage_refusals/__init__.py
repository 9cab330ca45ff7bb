"""Sessions whose database refuses at a random moment: full, locked, removed, without room for a byte."""
