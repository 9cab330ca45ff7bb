"""Sessions over REST: one resource, one route for every command, one line a kind."""
