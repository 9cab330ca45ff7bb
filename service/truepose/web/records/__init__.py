"""A page for each kind of record: a sentence, a picture, figures, how it came about, what to do next."""
