"""People, what opens the service to them, and what they did."""
