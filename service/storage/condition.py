"""How the storage is: whether it takes records, and what was found that should not be."""

import threading


class Condition:
    """Told by the threads of the database, asked by everybody."""

    def __init__(self) -> None:
        self._turn = threading.Lock()
        self._damage: dict[str, str] = {}  # by what was found, in the order of finding
        self.trouble: str | None = None  # why records are refused; None while they are taken

    @property
    def fault(self) -> str | None:
        """One sentence on what is amiss; None where nothing is."""
        with self._turn:
            found = [*self._damage.values()]
        told = [self.trouble] if self.trouble else []
        if found:
            more = f" ({len(found) - 1} more like this.)" if len(found) > 1 else ""
            told.append(f"{found[0]}{more}")
        return " ".join(told) or None

    def note_damage(self, what: str, sentence: str) -> None:
        """Keep what was found; once for each `what`."""
        with self._turn:
            self._damage.setdefault(what, sentence)

    def damage(self, what: str) -> str | None:
        """Return what was found under that name."""
        with self._turn:
            return self._damage.get(what)
