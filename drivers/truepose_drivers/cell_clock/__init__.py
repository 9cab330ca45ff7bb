"""The clock of a simulated cell, offered as one more endpoint."""
