"""A robot over months: causes, errors, what it was measured in, and two results side by side."""
