"""Work in a process of its own: tasks, messages, turns."""
