"""A measured campaign measured once more, in the simulated cell."""
