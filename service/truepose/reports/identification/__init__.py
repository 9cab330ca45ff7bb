"""The report of an identification: its headline, parameters, figures, and its short form on a terminal."""
