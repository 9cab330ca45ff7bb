"""How well a measurement determines each parameter: a picture, and a sentence."""
