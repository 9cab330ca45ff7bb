"""The power report of the diagnosis: effects hidden in simulated campaigns, and what is said of them."""
