"""Causes that the trade has no name for: where they act, what they depend on, with which shape."""
