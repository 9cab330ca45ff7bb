"""The truepose service: measures, identifies and validates industrial robots."""
