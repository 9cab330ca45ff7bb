"""A cell with a session running and its plant, both killed at random moments."""
