"""Ballbar sessions that a study takes up where it likes: the cell they stand in, the service, the copies."""
