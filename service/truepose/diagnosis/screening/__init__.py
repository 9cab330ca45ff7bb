"""What each candidate cause would explain beyond the fitted model, and which are taken: linear algebra."""
