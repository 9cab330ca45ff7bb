"""Schema of the database, one change a file; in the wheel, so that an installed service makes its own."""
