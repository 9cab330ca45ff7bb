"""Identification: nominal robot plus effects, fitted to observations; everything here is pure."""
