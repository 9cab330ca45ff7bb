"""Fleets from archives: what each campaign tells, computed once and kept, and the robots compared."""
