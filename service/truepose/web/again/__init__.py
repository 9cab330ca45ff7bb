"""Plans used again: a session as last time, in the cell of today."""
