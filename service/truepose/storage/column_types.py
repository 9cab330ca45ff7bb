"""Types of columns as every engine has them: what is written comes back bit for bit, in the same order."""

import math
from typing import Any, Final

import sqlalchemy as sa

# Compared and sorted byte by byte, as SQLite does it by itself, whatever language a server speaks.
TEXT: Final = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
WHOLE: Final = sa.Integer().with_variant(sa.BigInteger(), "postgresql")
DOCUMENT: Final = sa.JSON()  # of PostgreSQL `json`, which keeps the text as it was given; `jsonb` would not
BYTES: Final = sa.LargeBinary()


class Real(sa.TypeDecorator[float]):
    """A double as SQLite keeps it, which knows no negative zero and no NaN, so that hashes are the same."""

    impl = sa.Float
    cache_ok = True

    def process_bind_param(self, value: float | None, dialect: Any) -> float | None:
        """Return what is kept of a number."""
        return None if value is None or math.isnan(value) else float(value) + 0.0


REAL: Final = Real()
