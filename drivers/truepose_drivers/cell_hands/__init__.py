"""The person at a simulated cell."""
