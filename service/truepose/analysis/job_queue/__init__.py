"""Work in a process of its own: tasks, messages, the queue of jobs."""
