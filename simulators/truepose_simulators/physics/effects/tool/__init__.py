"""Physical effects of the tool."""
