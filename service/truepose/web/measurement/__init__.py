"""Sessions, readings and devices as REST resources."""
