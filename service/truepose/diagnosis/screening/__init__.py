"""Which causes the residuals ask for: candidates, tests of them, and the choice."""
