"""Least squares: the solver, gross readings, what the model lacks, cross-validation, certificates."""
