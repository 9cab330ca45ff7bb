"""A plant and its cells: what leaves a cell, its journal in the plant, and what can be looked up of it."""
