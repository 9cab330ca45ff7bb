"""Words, numbers and signs of a robot language, and the literal values that they make up."""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal, NamedTuple, TypeAlias, get_args

from truepose.exchange.programs.program import Number, Source

Kind: TypeAlias = Literal["word", "number", "string", "sign", "end"]
_KINDS: Final[Mapping[str, Kind]] = {kind: kind for kind in get_args(Kind)}
_CLOSES: Final = {")": "(", "]": "[", "}": "{"}
_OPENS: Final = frozenset(_CLOSES.values())
_LONGEST_SHOWN: Final = 60
_DEEPEST: Final = 50  # brackets in each other: nobody writes ten


class Token(NamedTuple):
    """A word, number, string or sign; "end" is the end of a line where the language has lines."""

    kind: Kind
    text: str
    start: int
    end: int

    @property
    def upper(self) -> str:
        """The text where capitals do not matter."""
        return self.text.upper() if self.kind == "word" else self.text


Tokens: TypeAlias = Sequence[Token]


@dataclass(frozen=True, slots=True)
class Language:
    """What the tokens of a language look like; `skipped` are blanks and comments."""

    skipped: str
    string: str
    lines: bool  # whether the end of a line ends a statement
    word: str = r"[A-Za-z_$\x80-\xff][\w$\x80-\xff]*"
    sign: str = r":=|."
    number: str = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"

    def pattern(self) -> re.Pattern[str]:
        """Return what finds one token."""
        ends = r"(?P<end>\r\n|\n|\r)|" if self.lines else ""
        # ASCII, since the text is Latin-1 for the sake of its places only: which letter a byte beyond is
        # nobody knows, and languages take all of them for letters.
        return re.compile(
            rf"{ends}(?P<skipped>{self.skipped})|(?P<string>{self.string})|(?P<number>{self.number})"
            rf"|(?P<word>{self.word})|(?P<sign>{self.sign})",
            re.DOTALL | re.ASCII,
        )


def tokens(source: Source, language: Language) -> Iterator[Token]:
    """Yield the tokens of a program.

    Raises
    ------
    UnreadableFileError
        A string does not end on its line.
    """
    for found in language.pattern().finditer(source.text, source.start):
        kind = _KINDS.get(found.lastgroup or "")
        if kind == "sign" and found.group() == '"':
            source.fail("the string that begins here does not end on its line", found.start())
        if kind is not None:
            yield Token(kind, found.group(), found.start(), found.end())


def statements(
    source: Source, found: Iterator[Token], ends: Callable[[Token], bool], *, continued: bool = False
) -> Iterator[list[Token]]:
    """Yield the tokens of every statement, up to and with the one that `ends` it.

    With `continued` an open bracket carries a statement over the end of its line.

    Raises
    ------
    UnreadableFileError
        A bracket does not close, or closes what was not open.
    """
    statement: list[Token] = []
    opened: list[Token] = []
    for token in found:
        if token.kind == "sign":
            _count(source, token, opened)
        if not ends(token):
            statement.append(token)
        elif not (opened and continued):
            _refuse_open(source, opened)
            yield [*statement, token]
            statement = []
    _refuse_open(source, opened)
    if statement:
        yield statement


def _count(source: Source, token: Token, opened: list[Token]) -> None:
    if token.text in _OPENS:
        opened.append(token)
        if len(opened) > _DEEPEST:
            source.fail("brackets are nested too deeply", token.start)
    elif token.text in _CLOSES:
        if not opened or opened[-1].text != _CLOSES[token.text]:
            source.fail(f"{token.text} closes a bracket that was not opened", token.start)
        opened.pop()


def _refuse_open(source: Source, opened: list[Token]) -> None:
    if opened:
        source.fail(f"the bracket {opened[-1].text} that begins here is not closed", opened[-1].start)


def closing(found: Tokens, opening: int) -> int:
    """Return where the bracket at `opening` closes."""
    depth = 0
    for index in range(opening, len(found)):
        if found[index].kind == "sign":
            depth += (found[index].text in _OPENS) - (found[index].text in _CLOSES)
        if depth == 0:
            return index
    return len(found) - 1


def bracket(found: Tokens, opening: str, at: int = 0) -> Tokens:
    """Return the index that begins at a place; no tokens where none begins there."""
    begins = at < len(found) and found[at].text == opening
    return found[at : closing(found, at) + 1] if begins else ()


def outside(found: Tokens) -> Iterator[int]:
    """Yield the places of the tokens outside brackets; the brackets themselves are inside."""
    index = 0
    while index < len(found):
        if found[index].kind == "sign" and found[index].text in _OPENS:
            index = closing(found, index)
        else:
            yield index
        index += 1


def parts(found: Tokens) -> list[Tokens]:
    """Return what stands between the commas outside brackets; nothing for no tokens."""
    if not found:
        return []
    commas = [index for index in outside(found) if found[index].text == ","]
    return [found[a + 1 : b] for a, b in pairwise([-1, *commas, len(found)])]


def inside(found: Tokens, opening: str) -> list[Tokens] | None:
    """Return the parts of what is one pair of brackets, else None."""
    if not found or found[0].text != opening or closing(found, 0) != len(found) - 1:
        return None
    return parts(found[1:-1])


def number(source: Source, found: Tokens) -> Number | None:
    """Return the number that is all that stands there, with its sign, or None."""
    if not found or found[-1].kind != "number":
        return None
    if len(found) == 1 or (len(found) == 2 and found[0].text in ("-", "+")):
        return source.number(found[0].start, found[-1].end)
    return None


def numbers(source: Source, found: Sequence[Tokens] | None, count: int) -> tuple[Number, ...] | None:
    """Return `count` numbers; None where something else stands there, or another count."""
    read = [number(source, part) for part in found or ()]
    literal = tuple(entry for entry in read if entry is not None)
    return literal if len(literal) == len(read) == count else None


def plain_digits(digits: str) -> str:
    """Return a whole number of any length without the zeros before it: 7 and 007 are one name."""
    return digits.lstrip("0") or "0"


def display_tokens(source: Source, found: Tokens) -> str:
    """Return tokens as a person reads them, cut where they are long."""
    if not found:
        return ""
    text = source.shown(found[0].start, found[-1].end)
    return text if len(text) <= _LONGEST_SHOWN else text[: _LONGEST_SHOWN - 3] + "..."
