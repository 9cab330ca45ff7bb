"""The database itself: its address, connections and schema, and its engine, SQLite or PostgreSQL."""
