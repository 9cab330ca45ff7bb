"""Nouns of the trade as frozen dataclasses; imports the standard library and numpy only."""
