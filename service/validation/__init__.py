"""Validation: a model against readings it was not made from."""

from service.validation.held_out import validate

__all__ = ["validate"]
