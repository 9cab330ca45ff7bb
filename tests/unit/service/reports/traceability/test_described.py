"""What is described without a name: one sentence with the largest, and what it is good for."""

from tests.helpers.diagnosis.answers import make_described, make_rest
from truepose.domain.diagnosis import EffectSize
from truepose.reports.diagnosis.rows import described_rows, described_sentence

FOLLOWED = [make_described(where=f"joint {k}", worth=EffectSize(0.3, 0.9, 0.1 * k)) for k in range(9, 0, -1)]


def test_the_sentence_names_the_largest_counts_the_others_and_says_what_they_gain():
    assert described_sentence(make_rest(*FOLLOWED[:5])) == (
        "Modelled empirically, without an identified cause, as far as the data require: "
        "joint 9 as a function of angle of joint 1 (0.900 mm), "
        "joint 8 as a function of angle of joint 1 (0.800 mm), "
        "joint 7 as a function of angle of joint 1 (0.700 mm), smaller terms: 2. "
        "This reduces the RMS error at unseen points by 0.0300 mm."
    )


def test_what_depends_on_nothing_is_its_place_alone():
    sentence = described_sentence(make_rest(make_described(where="nest 2", over="constant")))

    assert ": nest 2 (0.120 mm). This" in sentence


def test_the_table_holds_the_largest():
    rows = described_rows(tuple(FOLLOWED))

    assert len(rows) == 8
    assert (rows[0].place, rows[0].own) == ("joint 9 as a function of angle of joint 1", "0.900")
