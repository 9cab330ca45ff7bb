"""Sessions of closed loops: which configurations bring the tool to its targets, and what they tell."""
