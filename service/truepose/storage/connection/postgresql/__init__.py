"""PostgreSQL: a database of a server, which is held by a lock of the server."""
