"""Residuals along one variable, with what was fitted to them."""
