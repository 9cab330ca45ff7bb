"""FANUC robots with the Remote Motion Interface: joint targets as JSON over TCP."""
