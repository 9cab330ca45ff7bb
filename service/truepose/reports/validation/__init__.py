"""The report of a validation: errors, their places, ISO 9283."""
