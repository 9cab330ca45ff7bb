"""Halts: they hold from the moment at which somebody asks, on record or not yet."""
