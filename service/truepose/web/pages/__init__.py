"""Pages for people: one file for each kind of record with its report, and what all of them share."""
