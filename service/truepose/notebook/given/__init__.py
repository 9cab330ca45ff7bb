"""What a notebook gives: files, tables, arrays, and the robot they are of."""
