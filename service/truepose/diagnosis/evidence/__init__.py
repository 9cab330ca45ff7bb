"""What findings are worth: sensitivities, errors on readings left out, and structure of the residuals."""
