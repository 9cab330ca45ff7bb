"""The model of an arm: its structure, its predictions and their derivatives."""
