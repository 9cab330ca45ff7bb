"""Records on disk; the only room that imports sqlalchemy. All queries live in repositories."""
