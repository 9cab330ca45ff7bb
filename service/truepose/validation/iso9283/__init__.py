"""Characteristics of ISO 9283:1998: plans of their tests, and the figures that measured points give."""
