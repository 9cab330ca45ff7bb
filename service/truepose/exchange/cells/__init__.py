"""Cell files, and the simulated cell that is shipped."""
