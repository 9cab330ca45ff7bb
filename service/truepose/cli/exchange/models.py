"""Model files as commands take them."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

from truepose.cli.output import remark
from truepose.domain.errors import ConfigurationError
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.exchange.models.acceptance import CheckedModel


def checked_model(
    file: Path,
    max_shift_mm: float | None,
    words: Catalogue,
    *,
    accept_edited: bool,
    robot_follows: bool = True,
) -> "CheckedModel":
    """Read a model file that is accepted and print what is remarkable on it; raises InputFileError."""
    from truepose.exchange.models.acceptance import Acceptance, read_checked_model

    if max_shift_mm is not None and not 0.0 < max_shift_mm < math.inf:
        raise ConfigurationError(
            f"--max-shift-mm {max_shift_mm:g}: give the largest shift of the tool to accept, above 0 mm."
        )
    found = read_checked_model(file, Acceptance(max_shift_mm, accept_edited), robot_follows=robot_follows)
    remark(map(words.spoken, found.remarks))
    return found
