"""The plan of a tracker session: its steps, their operations, and what is said of them beforehand."""
