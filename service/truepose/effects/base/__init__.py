"""Effects of the base: where the robot stands, and how that gives or moves."""
