"""A Leica AT401 as its emScon server shows it on the wire."""
