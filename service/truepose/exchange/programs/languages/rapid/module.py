"""Statements of a RAPID module, and in which routine each stands.

Source: ABB, Technical reference manual, RAPID overview, "Basic RAPID programming". A routine ends with its
own word, not with a semicolon, and so do the branches of an IF: a statement here is what stands between
two semicolons or such words.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from truepose.exchange.programs.source import Source
from truepose.exchange.programs.tokens import Language, Token, Tokens, closing, outside, statements, tokens

_LANGUAGE: Final = Language(
    skipped=r"[ \t\f\v\r\n]+|![^\r\n]*", string=r'"(?:[^"\r\n]|"")*"', lines=False, sign=r":=|."
)
_CLOSED_BY: Final = {"MODULE": "ENDMODULE", "PROC": "ENDPROC", "FUNC": "ENDFUNC", "TRAP": "ENDTRAP"}
_ROUTINES: Final = frozenset({"PROC", "FUNC", "TRAP"})
_NAMES_BEHIND: Final = {"MODULE": 1, "PROC": 1, "FUNC": 2, "TRAP": 1}  # of a function also its type
_BRANCHES: Final = frozenset({
    "IF", "THEN", "ELSEIF", "ELSE", "ENDIF", "FOR", "DO", "ENDFOR", "WHILE", "ENDWHILE", "TEST", "CASE",
    "DEFAULT", "ENDTEST", "ERROR", "UNDO", "BACKWARD", "RECORD", "ENDRECORD",
})  # fmt: skip
_BEHIND_CONDITIONS: Final = frozenset({"THEN", "DO"})
_WORDS: Final = frozenset({*_CLOSED_BY, *_CLOSED_BY.values(), *_BRANCHES})


@dataclass(frozen=True, slots=True)
class Routine:
    """A routine, or the module around it; `arguments` in capitals."""

    number: int = 0
    arguments: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Statement:
    """The words of a statement, without what ended it."""

    words: Tokens
    routine: Routine
    branches: bool  # whether a branch or a routine begins or ends behind it
    is_condition: bool


def read_statements(source: Source) -> Iterator[Statement]:
    """Yield the statements of a module.

    Raises
    ------
    UnreadableFileError
        A module, a routine or a statement does not end.
    """
    routine, count, behind = Routine(), 0, ""
    opened: list[Token] = []
    for found in statements(source, tokens(source, _LANGUAGE), _ends):
        end = found[-1]
        if not _ends(end):
            source.fail("the statement that begins here does not end with ;", found[0].start)
        head, words = _head(behind, found[:-1])
        if behind in _ROUTINES:
            count += 1
            routine = Routine(count, frozenset(token.upper for token in head))
        yield Statement(words, routine, end.text != ";", end.upper in _BEHIND_CONDITIONS)
        behind = end.upper
        if end.upper in _CLOSED_BY:
            opened.append(end)
        elif end.upper in _CLOSED_BY.values():
            _close(source, end, opened)
            routine = Routine()
    if opened:
        _refuse_open(source, opened[-1])


def assignment_at(words: Tokens) -> int | None:
    """Return where the sign of an assignment stands; that of an option of a call is none."""
    for index in outside(words):
        if words[index].text == "\\":
            return None
        if words[index].text == ":=":
            return index
    return None


def _ends(token: Token) -> bool:
    return token.text == ";" if token.kind == "sign" else token.kind == "word" and token.upper in _WORDS


def _head(begin: str, words: Tokens) -> tuple[Tokens, Tokens]:
    """Return what is said of a routine or module behind the word that begins it, and its first statement.

    Among the arguments of a routine are the words of their types, which do no harm.
    """
    names = _NAMES_BEHIND.get(begin, 0)
    opening = words[names] if len(words) > names else None
    has_brackets = names > 0 and opening is not None and opening.text == "("
    end = closing(words, names) + 1 if has_brackets else names
    return words[:end], words[end:]


def _close(source: Source, end: Token, opened: list[Token]) -> None:
    if not opened:
        source.fail(f"{end.text} ends what has not begun", end.start)
    begin = opened.pop()
    if _CLOSED_BY[begin.upper] != end.upper:
        _refuse_open(source, begin)


def _refuse_open(source: Source, begin: Token) -> None:
    end = _CLOSED_BY[begin.upper]
    source.fail(f"the {begin.text} that begins here has no {end}; the file is cut off", begin.start)
