"""Random ballbar sessions with an operator who errs at every step and a cell that changes."""
