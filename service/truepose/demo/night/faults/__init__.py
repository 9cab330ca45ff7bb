"""What goes wrong in a night: bad lines, kills, faulty sessions, planted causes."""
