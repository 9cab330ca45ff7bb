"""A part of the study of any requests: nobody, in whatever role, has the service fail or end a connection."""

from tests.helpers.web.strangers import outcome_of


def test_no_request_has_the_service_fail(tmp_path):
    outcome = outcome_of(tmp_path, 250, seed=7)

    assert [(role, asked.name, answer.status) for role, asked, answer in outcome.failed] == []
    assert outcome.statuses.total() == 250
    assert {200, 401, 403, 404, 422} <= set(outcome.statuses)
