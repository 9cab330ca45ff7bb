"""The database file: its address, lock and schema, the SQLite library, and connections to it."""
