"""What to do or to measure next so that a diagnosis becomes surer."""
