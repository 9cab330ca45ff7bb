"""A database that a demo run left, for tests that look at records of every kind."""
