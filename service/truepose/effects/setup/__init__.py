"""Effects of what stands around the arm: base, tool, instruments."""
