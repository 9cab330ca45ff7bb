"""Physical effects of links."""
