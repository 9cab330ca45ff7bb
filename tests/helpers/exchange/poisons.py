"""Files as a stranger may bring them: sound ones with words dropped, doubled or replaced by a poison."""

import re

_WORD = re.compile(rb"[A-Za-z_]\w*|[-+]?[0-9][0-9.eE+-]*|[ \t]+|\r?\n|.", re.DOTALL)
_KEY = re.compile(rb"[A-Za-z]")
DEEP = 900
LONG = 20_000
POISONS = {
    "nan": b"nan",
    "inf": b"-inf",
    "1e999": b"1e999",
    "1e29": b"1e29",
    "denormal": b"4.9e-324",
    "-1": b"-1",
    "0": b"0",
    "1_0": b"1_0",
    "a huge count": b"3000000",
    "400 digits": b"9" * 400,
    "5,000 digits": b"7" * 5000,
    "an exponent of 5,000 digits": b"0e-" + b"7" * 5000,
    "digits that end in a letter": b"7" * LONG + b"x",
    "blanks": b" " * LONG,
    "words": b"a1 " * LONG,
    "lines": b"\n" * LONG,
    "a long line": b"z" * 140_000,
    "lists in lists": b"[" * DEEP + b"]" * DEEP,
    "open lists": b"[" * DEEP,
    "calls in calls": b"f(" * DEEP + b")" * DEEP,
    "indices in indices": b"p[" * DEEP + b"]" * DEEP,
    "elements in elements": b"<a>" * DEEP + b"</a>" * DEEP,
    "open elements": b"<a>" * DEEP,
    "objects in objects": b'{"a":' * DEEP + b"1" + b"}" * DEEP,
    "names in names": b"a" + b".a" * 3000,
    "half a character": b'"\\ud800"',
    "a broken character": b"\xff\xc3",
    "a zero byte": b"\0",
    "an open quote": b'"',
    "an apostrophe": b"'",
    "a lone return": b"\r",
    "an entity": b"&a;",
    "a document type": b'<!DOCTYPE a [<!ENTITY b "c">]>',
    "an alias": b"&a [*a, *a]",
    "a date": b"2026-13-45",
    "null": b"null",
    "an object": b"{}",
    "a truth": b"true",
}
_ENCODINGS = (b"banana", b"shift_jis", b"utf-16", b"utf-7")


def poisoned(data, draw, most=3):
    """Return a text of which up to `most` words are otherwise."""
    words = _WORD.findall(data)
    for _ in range(draw.randint(1, most)):
        if words:
            _poison(words, draw)
    return b"".join(words)


def _poison(words, draw):
    at = draw.randrange(len(words))
    match draw.randrange(8):
        case 0:
            del words[at : at + draw.choice([1, 1, 3, 20])]
        case 1:
            words[at:at] = words[at : at + draw.choice([1, 1, 5, 40])]
        case 2:
            words[at:at] = [draw.choice([*POISONS.values()])]
        case 3:
            words[at] = _KEY.sub(lambda found: b"\\u%04x" % ord(found[0]), words[at])
        case 4 if b'encoding="' in (head := b"".join(words[:40])):
            words[:40] = [re.sub(rb'encoding="[^"]*"', b'encoding="%s"' % draw.choice(_ENCODINGS), head)]
        case 5:
            words[at], words[-at] = words[-at], words[at]
        case _:
            words[at] = draw.choice([*POISONS.values()])
