"""Effects of the joints: what gears, springs and shafts make of the angle that was asked for."""
