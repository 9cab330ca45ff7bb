"""Figures over one variable: residuals, waves, days, hours, configurations."""
