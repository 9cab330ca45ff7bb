"""Errors of collecting from cells.

PlantError
└── CellAnswerError    a cell does not answer, or not as one
    └── CellSilentError  it does not answer at all

What a cell's records can be wrong in is among the errors of the storage: it keeps none of those.
"""

from truepose.domain.errors import TrueposeError


class PlantError(TrueposeError):
    """Base of every error of collecting from cells."""


class CellAnswerError(PlantError):
    """A cell does not answer, or not as one."""


class CellSilentError(CellAnswerError):
    """A cell does not answer at all."""
