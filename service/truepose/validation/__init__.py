"""Validation: a model against readings it was not made from, and readings against what was asked for."""
