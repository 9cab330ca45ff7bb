"""SQLite: a file, and what lies beside it."""
