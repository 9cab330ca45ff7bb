"""The report of a ballbar sphere test, and its sentences."""
