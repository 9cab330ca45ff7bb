"""A real PostgreSQL server of the distribution's package, for as long as tests use it."""
