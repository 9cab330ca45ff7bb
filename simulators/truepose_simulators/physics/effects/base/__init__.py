"""Physical effects of the base."""
