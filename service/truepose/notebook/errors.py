"""Errors of the notebook's face; all else that it raises comes from what it calls.

TrueposeError
└── MissingExtraError    something that is only installed on request is needed
"""

from truepose.domain.errors import TrueposeError


class MissingExtraError(TrueposeError):
    """Something that is only installed on request is needed."""
