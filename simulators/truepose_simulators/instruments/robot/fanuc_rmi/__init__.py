"""A controller of FANUC with the Remote Motion Interface."""
