"""The parameters of a model: of its effects, of base nests, of targets; what they move."""
