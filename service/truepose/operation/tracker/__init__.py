"""Tracker sessions as the desk runs them."""
