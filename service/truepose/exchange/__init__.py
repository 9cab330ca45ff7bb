"""Files in and out: the only room that parses what users wrote."""
