"""Tables of readings and of points: strict reading, and the columns of each kind."""
