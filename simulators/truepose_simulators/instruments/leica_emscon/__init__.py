"""A Leica AT401, or with a probe an AT901, as its emScon server shows it on the wire."""
