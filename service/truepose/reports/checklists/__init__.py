"""A plan on paper: what to prepare, and what to do at each stop, with boxes to tick."""
