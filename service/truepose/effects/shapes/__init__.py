"""Shapes that several effects share: drifts, jumps and rigid motions, in time or drawn anew each time."""
