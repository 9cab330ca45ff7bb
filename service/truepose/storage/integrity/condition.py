"""How the storage is: whether it takes records, and what was found that should not be."""

import threading
from typing import Final, Literal, TypeAlias

Integrity: TypeAlias = Literal["not_checked", "checking", "whole", "damaged"]
RESERVE_IN_USE: Final = (
    "The disk is full; what is under way is brought to its end with a reserve of 16 MB, and nothing new "
    "begins until there is room."
)
FOREIGN: Final = "foreign"  # damage that a verification clears


class Condition:
    """Told by the threads of the database, asked by everybody."""

    def __init__(self) -> None:
        self._turn = threading.Lock()
        self._damage: dict[str, str] = {}  # by what was found, in the order of finding
        self._checked: Integrity = "not_checked"
        self.verified_share = 0.0  # of the verification under way, or of the last one
        self.trouble: str | None = None  # why records are refused; None while they are taken
        self.low: str | None = None  # why nothing new begins, while records are taken

    @property
    def fault(self) -> str | None:
        """One sentence on what is amiss; None where nothing is."""
        return " ".join(told for told in (self.trouble, self.low, self.damage) if told) or None

    @property
    def damage(self) -> str | None:
        """One sentence on what was found that should not be; None where nothing was."""
        with self._turn:
            found = [*self._damage.values()]
        if not found:
            return None
        more = f" ({len(found) - 1} more like this.)" if len(found) > 1 else ""
        return f"{found[0]}{more}"

    @property
    def integrity(self) -> Integrity:
        """Whether the database is known to hold what was written."""
        return "damaged" if self._damage else self._checked

    @property
    def damaged(self) -> bool:
        """Whether anything was found."""
        return bool(self._damage)

    def note_damage(self, what: str, sentence: str) -> None:
        """Keep what was found; once for each `what`."""
        with self._turn:
            self._damage.setdefault(what, sentence)

    def begin_verification(self) -> None:
        """Say that everything is being looked through."""
        self._checked, self.verified_share = "checking", 0.0

    def end_verification(self, *, whole: bool) -> None:
        """Say what came of it: what others wrote has changed no record where everything is whole."""
        self._checked, self.verified_share = "whole" if whole else "damaged", 1.0
        if whole:
            with self._turn:
                self._damage.pop(FOREIGN, None)
