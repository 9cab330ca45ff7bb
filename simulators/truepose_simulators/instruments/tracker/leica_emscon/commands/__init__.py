"""Commands of the emScon interface, and what the simulated tracker does for each."""
