"""Small tables for a notebook; whatever came from a file is escaped."""

from collections.abc import Iterable, Sequence

from markupsafe import Markup, escape

_TABLE = Markup("<table><caption>{}</caption><thead><tr>{}</tr></thead><tbody>{}</tbody></table>")
_MOST_ROWS = 10  # of a table that has as many as the data
_LEFT, _RIGHT = Markup('style="text-align: left"'), Markup('style="text-align: right"')


def page(*parts: Markup) -> str:
    """Return the parts as what a notebook shows of one value."""
    return str(Markup("<div>{}</div>").format(Markup("").join(parts)))


def paragraphs(sentences: Iterable[str]) -> Markup:
    """Return each sentence as a paragraph."""
    return Markup("").join(Markup("<p>{}</p>").format(sentence) for sentence in sentences)


def table(
    caption: str, head: Sequence[str], rows: Iterable[Sequence[str]], *, numbers_from: int = 1
) -> Markup:
    """Return a table of texts; columns from `numbers_from` on, counted from 0, are aligned to the right."""
    names = _cells(head, "th", numbers_from)
    lines = Markup("").join(Markup("<tr>{}</tr>").format(_cells(row, "td", numbers_from)) for row in rows)
    return _TABLE.format(caption, names, lines)


def first_rows(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Markup:
    """Return a table of numbers as long as a notebook has room for, and say how many rows are left."""
    left = len(rows) - _MOST_ROWS
    more = [f"and {left} more rows"] if left > 0 else []
    return table("", head, rows[:_MOST_ROWS], numbers_from=0) + paragraphs(more)


def _cells(texts: Sequence[str], tag: str, numbers_from: int) -> Markup:
    return Markup("").join(
        Markup("<{0} {1}>{2}</{0}>").format(Markup(tag), _LEFT if k < numbers_from else _RIGHT, escape(text))
        for k, text in enumerate(texts)
    )
