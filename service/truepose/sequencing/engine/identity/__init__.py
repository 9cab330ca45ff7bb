"""Which device answers, and whether it is the one that is expected."""
