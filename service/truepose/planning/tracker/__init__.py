"""Plans of tracker sessions."""
