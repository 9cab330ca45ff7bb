"""A validation on a terminal."""

from rich.console import Group
from rich.table import Table
from rich.text import Text

from truepose.domain.results.validation import Validation, ValidationUncertainty
from truepose.judgement.cautions import pose_test_caution
from truepose.judgement.iso9283.judged import PoseTest
from truepose.reports.terminal.errors import add_pair, error_table, title_of
from truepose.reports.validation.pose_test_rows import drift_sentences, pose_test_rows, withheld_sentences
from truepose.reports.validation.sentences import decision_sentence, verdict_sentence
from truepose.reports.wording.turns import turns_table
from truepose.words.catalogue import IN_ENGLISH, Catalogue


def validation_summary(validation: Validation, words: Catalogue = IN_ENGLISH) -> Group:
    """Return the errors of positions (or lengths) and of distances, and whether they pass."""
    positions = validation.quantity == "position"
    table = error_table(title_of(validation), words)
    label = words.say("validation.positions" if positions else "validation.lengths")
    known = validation.uncertainty or ValidationUncertainty()
    add_pair(table, label, validation.position, words, known.position)
    if validation.relative is not None:
        add_pair(table, words.say("validation.relative"), validation.relative, words, known.relative)
    if validation.distance is not None:
        add_pair(table, words.say("validation.distances"), validation.distance, words, known.distance)
    told = verdict_sentence(validation), decision_sentence(validation)
    turns = turns_table(validation, words)
    tables = (table,) if turns is None else (table, turns)
    return Group(*tables, *(Text(words.spoken(sentence)) for sentence in told if sentence))


def pose_test_summary(test: PoseTest, words: Catalogue = IN_ENGLISH) -> Group:
    """Return the figures of ISO 9283 without their components, what is withheld, what they do not prove."""
    table = Table(title="ISO 9283:1998")
    for key in ("terminal.figure", "terminal.clause", "terminal.pose", "terminal.commanded_by"):
        table.add_column(words.say(key))
    for name in (words.say("terminal.value"), "u"):
        table.add_column(name, justify="right")
    table.add_column(words.say("terminal.unit"))
    table.add_column(words.say("terminal.noise_alone"), justify="right")
    for row in (row for row in pose_test_rows(test, words) if row.whole):
        table.add_row(
            row.name, row.clause, row.subject, row.commanded_by, row.value, row.u, row.unit, row.noise
        )
    withheld = (
        Text(words.say("pose_test.withheld.line", sentence=sentence))
        for sentence in withheld_sentences(test, words)
    )
    drift = (Text(words.spoken(sentence)) for sentence in drift_sentences(test))
    return Group(table, *withheld, *drift, Text(words.spoken(pose_test_caution(test))))
