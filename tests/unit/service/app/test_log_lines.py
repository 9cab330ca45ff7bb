import logging

from truepose.app.logs import FewRepeats


def written(records):
    """Return the lines that pass, of pairs of a time and a record."""
    now_s = 0.0
    few = FewRepeats(lambda: now_s)
    lines = []
    for now_s, record in records:  # noqa: B007  # the clock reads it
        if few.filter(record):
            lines.append(record.getMessage())
    return lines


def line(text, *said, name="truepose.sequencing"):
    return logging.LogRecord(name, logging.WARNING, "", 0, text, said, None)


def test_much_of_the_same_is_five_lines_and_a_count():
    storm = [(0.001 * number, line("no more %s", "files")) for number in range(1000)]

    lines = written([*storm, (11.0, line("no more %s", "files"))])

    assert len(lines) == 6
    assert lines[-1] == "no more files (and 995 similar lines, not written)"


def test_what_strangers_cause_counts_as_one_whatever_it_says():
    storm = [(0.0, line("socket %d", number, name="asyncio")) for number in range(1000)]

    assert len(written(storm)) == 5


def test_different_lines_of_ours_are_all_written():
    assert len(written([(0.0, line("session %d", number)) for number in range(100)])) == 100


def test_a_line_now_and_then_is_written_as_it_is():
    lines = written([(60.0 * number, line("still here")) for number in range(10)])

    assert lines == ["still here"] * 10
