"""Drawn campaigns, most of them odd: every question is answered, or refused in one sentence.

`python -m tests.studies.drawn_campaigns --n 10000` asks about more of them.
"""

from collections import Counter

import pytest

from tests.studies.drawn_campaigns.asking import asked_about


@pytest.mark.parametrize("seed", [*range(2, 19), 1003, 100840])
def test_a_campaign_that_is_read_ends_in_an_answer_or_a_refusal(seed):
    _, asked = asked_about(seed)

    assert [one for one in asked if one.ending == "failure"] == []


def test_most_of_what_is_asked_is_answered():
    endings = Counter(one.ending for seed in range(10, 19) for one in asked_about(seed)[1])

    assert endings["answer"] > endings["refusal"]
