"""What recorded pages say: nothing that no person reads, and one figure for a fact wherever it stands."""

import json
import re

import pytest

from tests.recorded.transcript import KEPT

# What programs print of themselves, and numbers that nobody rounded. "None:" begins sentences.
_UNREADABLE = re.compile(
    r"\b(?:NaN|nan|undefined|Infinity|null)\b|\bNone\b(?!:)|\[object|(?<![\w.])\d+\.\d{7,}"
)
_ASKED = re.compile(r"^### ", re.MULTILINE)
_OUTCOME = re.compile(r"^Mean error \S+ mm before \(nominal\), .*$", re.MULTILINE)
_NUMBER = re.compile(r"-?[\d,]*\.?\d+")
_MODELS = ("nominal", "identified", "initial model", "after")
_RESULTS = ("identification", "diagnosis", "validation")
_PLURALS = {"diagnosis": "diagnoses"}


def answers():
    """Yield what was asked on all recorded days, and the text of each answer."""
    for file in sorted(KEPT.rglob("*.txt")):
        for part in _ASKED.split(file.read_text("utf-8"))[1:]:
            asked, _, answer = part.partition("\n")
            yield asked, answer


PAGES = [
    (asked, answer) for asked, answer in answers() if re.search(r"^-> \d+ text/html", answer, re.MULTILINE)
]


def document_of(kind):
    """Return a result as the service answers it to programs."""
    path = f"GET /api/v1/{_PLURALS.get(kind, f'{kind}s')}/1"
    answer = next(answer for asked, answer in answers() if asked == path)
    return json.loads(answer.partition("\n")[2])["document"]


def pages_of(kind):
    """Return the page of a result and its report, as text."""
    wanted = {f"GET /{_PLURALS.get(kind, f'{kind}s')}/1", f"GET /reports/{kind}/1"}
    return [answer for asked, answer in PAGES if asked in wanted]


def blocks(node):
    """Yield all statistics of errors in a document: n, mean, RMS, SD, largest, noise."""
    if isinstance(node, dict):
        if "rms_mm" in node and "n" in node:
            yield [node[name] for name in ("n", "mean_mm", "rms_mm", "sd_mm", "max_mm", "noise_mm")]
        for part in node.values():
            yield from blocks(part)
    elif isinstance(node, list):
        for part in node:
            yield from blocks(part)


def rows(page):
    """Yield the figures of each row of a table of errors."""
    lines = page.splitlines()
    for at, line in enumerate(lines):
        cells = lines[at + 1 : at + 7]
        if line in _MODELS and len(cells) == 6 and all(map(_NUMBER.fullmatch, cells)):
            yield cells
        elif line in _MODELS and len(cells) == 6 and all(map(_NUMBER.fullmatch, lines[at + 2 : at + 8])):
            yield lines[at + 2 : at + 8]  # a remark stands between


def agrees(shown, value):
    """Whether a printed number is a value, rounded to what is printed."""
    decimals = len(shown.partition(".")[2])
    return abs(float(shown.replace(",", "")) - value) <= 0.5001 * 10.0**-decimals


def value_behind(page, label):
    """Return the numbers that stand behind a label on a page."""
    found = re.findall(rf"^{re.escape(label)}\n({_NUMBER.pattern}) mm$", page, re.MULTILINE)
    assert found, label
    return found


@pytest.mark.parametrize(("asked", "page"), PAGES, ids=[asked for asked, _ in PAGES])
def test_no_page_prints_what_no_person_reads(asked, page):
    assert [line for line in page.splitlines() if _UNREADABLE.search(line)] == []


def test_no_command_prints_what_no_person_reads():
    commands = re.split(r"^\$ truepose ", (KEPT / "commands.txt").read_text("utf-8"), flags=re.MULTILINE)
    told = [one for one in commands[1:] if "--json" not in one.partition("\n")[0]]

    assert told
    assert [line for one in told for line in one.splitlines() if _UNREADABLE.search(line)] == []


@pytest.mark.parametrize(
    "line", ["NaN", "off by NaN before", "None", "0.6056475987081618", "[object Object]"]
)
def test_what_no_person_reads_is_noticed(line):
    assert _UNREADABLE.search(line)


@pytest.mark.parametrize("kind", _RESULTS)
def test_every_place_begins_a_result_with_the_same_sentence(kind):
    outcome = document_of(kind)["outcome"]

    page, report = pages_of(kind)

    assert {*_OUTCOME.findall(page), *_OUTCOME.findall(report)} == {outcome}


@pytest.mark.parametrize("kind", _RESULTS)
def test_every_row_of_errors_is_one_of_the_document(kind):
    document = document_of(kind)
    known = list(blocks(document))
    # A transcript has only the first shells of errors by place: their rows are left out by their numbers.
    whole = {block[0] for block in blocks({**document, "places": None})}

    shown = [row for page in pages_of(kind) for row in rows(page) if float(row[0]) in whole]

    assert len(shown) >= 4
    for row in shown:
        assert any(all(map(agrees, row, block)) for block in known), row


@pytest.mark.parametrize(
    ("kind", "label", "path"),
    [
        ("identification", "Mean error before", "statistics.validation.nominal.mean_mm"),
        ("identification", "Mean error after", "statistics.validation.identified.mean_mm"),
        ("identification", "Largest error after", "statistics.validation.identified.max_mm"),
        ("validation", "Largest error with the model", "position.identified.max_mm"),
        ("diagnosis", "Mean error before", "nominal.mean_mm"),
        ("diagnosis", "Mean error after", "after.mean_mm"),
    ],
)
def test_a_figure_is_that_of_the_document_wherever_it_stands(kind, label, path):
    value = document_of(kind)
    for name in path.split("."):
        value = value[name]

    shown = [number for page in pages_of(kind) if label in page for number in value_behind(page, label)]

    assert shown
    assert all(agrees(number, value) for number in shown)


_SAID = re.compile(r"Mean error (\S+) mm before \(nominal\), (\S+) mm after;(?: largest (\S+) mm,)?")


@pytest.mark.parametrize(
    ("kind", "models", "label"),
    [
        ("identification", ("validation.nominal", "validation.identified"), "Mean error {}"),
        ("diagnosis", ("nominal", "after"), "Mean error {}"),
        ("validation", ("position.nominal", "position.identified"), ""),
    ],
)
def test_cards_and_tables_print_a_figure_as_the_sentence_does(kind, models, label):
    document, pages = document_of(kind), pages_of(kind)
    *means, largest = _SAID.match(document["outcome"]).groups()

    for said, model, when in zip(means, models, ("before", "after"), strict=True):
        of = document.get("statistics", document) if kind == "identification" else document
        for name in model.split("."):
            of = of[name]
        rows_of_it = [row for page in pages for row in rows(page) if agrees(row[2], of["rms_mm"])]
        cards = [
            number
            for page in pages
            if label and label.format(when) in page
            for number in value_behind(page, label.format(when))
        ]
        assert {*cards, *(row[1] for row in rows_of_it)} == {said}
        assert largest is None or when == "before" or {row[4] for row in rows_of_it} == {largest}


@pytest.mark.parametrize(
    ("kind", "fact"),
    [("identification", "Measured by"), ("identification", "Written"), ("diagnosis", "Written")],
)
def test_a_fact_is_the_same_on_the_cover_in_the_head_and_among_the_conditions(kind, fact):
    report = pages_of(kind)[-1]

    said = [
        *re.findall(rf"\b{fact}: ([^·\n]+?)(?: ·|$)", report, re.MULTILINE),
        *re.findall(rf"^{fact}\n(.+)$", report, re.MULTILINE),
    ]

    assert len(said) >= 2
    assert len(set(said)) == 1
