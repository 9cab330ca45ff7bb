"""Runs on simulated cells that show what the program can do: demo, night run, accuracy report."""
