"""Where a model holds: its robot, its zone, its days, and what it lacks."""
