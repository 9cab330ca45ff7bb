"""Scripted failures: what goes wrong in the cell, and when."""
