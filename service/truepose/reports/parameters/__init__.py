"""The parameters of a model as a reader meets them: rows and meanings."""
