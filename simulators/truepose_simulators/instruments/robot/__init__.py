"""The robot controller: the servers that speak for the arm."""
