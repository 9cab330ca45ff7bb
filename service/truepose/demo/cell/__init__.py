"""One simulated cell and its service under way: processes, the REST client, what the simulator knows."""
