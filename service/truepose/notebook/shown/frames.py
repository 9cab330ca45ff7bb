"""Answers as DataFrames; pandas is asked for only when somebody wants one."""

import io
from typing import TYPE_CHECKING

from truepose.notebook.errors import MissingExtraError

if TYPE_CHECKING:
    from pandas import DataFrame


def frame(rows: object) -> "DataFrame":
    """Return a DataFrame of a list of rows, or of columns by name; raises MissingExtraError."""
    _require_pandas()
    from pandas import DataFrame

    return DataFrame(rows)


def frame_of_text(table: str) -> "DataFrame":
    """Return the DataFrame of a CSV text; raises MissingExtraError."""
    _require_pandas()
    from pandas import read_csv

    return read_csv(io.StringIO(table))


def _require_pandas() -> None:
    try:
        import pandas  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(
            "A DataFrame needs pandas, which is not installed: pip install 'truepose[notebook]'."
        ) from error
