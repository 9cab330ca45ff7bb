"""Identifications, validations and diagnoses as JSON documents."""
