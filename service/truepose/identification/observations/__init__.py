"""What was observed, one module a kind: residuals, derivatives and weights of its readings."""
