"""Readings set aside over REST: a result without them that says so, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.builders import make_points, make_stops
from tests.helpers.identification.synthetic import measured, nominal_campaign
from tests.integration.web.bench import ZIP
from truepose.exchange.campaigns.zip_file import write_campaign_zip

EFFECTS = ["base", "geometry"]
SENTENCE = "2 readings set aside by Ada Byron: the tool was touched."
ONE = {"config": 8, "nest": 2}
KINDS = ("identifications", "diagnoses")


@pytest.fixture(scope="module")
def archive():
    """Forty readings that identify, by three nests in turn, and three others that judge."""
    campaign = measured(nominal_campaign(40), effects=tuple(EFFECTS))[0]
    judging = make_points(3, 6, stops=make_stops(3, 6, config=np.array([101, 102, 103])))
    return write_campaign_zip(replace(campaign, validation=judging))


@pytest.fixture
async def campaign_id(client, archive):
    return (await client.post("/api/v1/campaigns", content=archive, headers=ZIP)).json()["id"]


def aside(*readings, **changes):
    return {"person": "Ada Byron", "reason": "the tool was touched", "readings": [*readings], **changes}


async def asked(client, kind, campaign_id, set_aside):
    body = {"campaign_id": campaign_id, "effects": EFFECTS, "set_aside": set_aside}
    return await client.post(f"/api/v1/{kind}", json=body)


async def made(client, until, kind, campaign_id, set_aside):
    """Return the job and the record of what it made."""
    answer = await asked(client, kind, campaign_id, set_aside)
    assert answer.status_code == 202, answer.text
    job = await until(answer.headers["Location"], "state", "succeeded", "failed")
    assert job["state"] == "succeeded", job["message"]
    return job, (await client.get(job["result_url"])).json()


@pytest.mark.parametrize("kind", KINDS)
async def test_a_result_without_readings_lists_them_and_says_so_on_its_page(client, until, campaign_id, kind):
    job, found = await made(client, until, kind, campaign_id, aside(ONE, {"config": 12, "nest": 3}))
    page = (await client.get(f"/{kind}/1?whole=true")).text
    model = (await client.get(f"/api/v1/models/{found['model_id']}/file")).json()

    told = found["document"]["set_aside"]
    assert (told["person"], told["reason"], told["rows"]) == ("Ada Byron", "the tool was touched", [7, 11])
    assert [(one["config"], one["nest"]) for one in told["readings"]] == [(8, 2), (12, 3)]
    assert job["request"]["set_aside"] == told
    assert SENTENCE in job["message"] and SENTENCE in found["document"]["message"]
    assert SENTENCE in page
    assert "configuration 8, nest 2; configuration 12, nest 3" in page
    assert model["identified_from"]["readings_set_aside"] == 2


async def test_the_campaign_keeps_what_a_result_is_made_without(client, until, campaign_id):
    before = (await client.get(f"/api/v1/campaigns/{campaign_id}/archive")).content
    await made(client, until, "identifications", campaign_id, aside(ONE))
    _, whole = await made(client, until, "identifications", campaign_id, None)

    assert (await client.get(f"/api/v1/campaigns/{campaign_id}/archive")).content == before
    assert whole["document"]["set_aside"] is None
    counts = [
        (await client.get(f"/api/v1/identifications/{number}")).json()["document"]["counts"]["observations"]
        for number in (1, 2)
    ]
    assert counts == [39 * 3, 40 * 3]


async def test_charts_show_the_readings_that_are_left_or_those_that_judge(client, until, campaign_id):
    await made(client, until, "identifications", campaign_id, aside(ONE))
    residuals = "/api/v1/identifications/1/residuals"

    left, judging = [(await client.get(f"{residuals}{of}")).json() for of in ("?identified_from=true", "")]

    assert len(left["config"]) == 39 and 8 not in left["config"]
    assert judging["config"] == [101, 102, 103]
    assert left["base_point"] is left["target"] is None
    space = (await client.get("/api/v1/identifications/1/space?identified_from=true")).json()
    assert space["total"] == 39


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("set_aside", "why"),
    [
        (aside({"config": 8, "nest": 3}), "has no reading of configuration 8, nest 3"),
        (aside({"config": 99, "nest": 1}), "has no reading of configuration 99, nest 1"),
        (aside({"config": 102, "nest": 1}), "judges the model and cannot be set aside"),
        (
            aside(*({"config": k + 1, "nest": k % 3 + 1} for k in range(9))),
            "9 of 40 readings are more than 20%",
        ),
        (aside(*({"config": k + 1, "nest": k % 3 + 1} for k in range(40))), "40 of 40 readings"),
        (aside(ONE, reason=""), "reason"),
        (aside(ONE, reason="  "), "reason"),
        (aside(ONE, person=None), "person"),
        (aside(), "readings"),
    ],
)
async def test_what_cannot_be_set_aside_is_refused_and_nothing_is_queued(
    client, campaign_id, kind, set_aside, why
):
    refused = await asked(client, kind, campaign_id, set_aside)

    assert refused.status_code == 422
    assert why in refused.json()["detail"]
    assert (await client.get("/api/v1/jobs")).json() == []


async def test_the_page_offers_what_can_be_done_with_a_selection(client, until, campaign_id):
    await made(client, until, "identifications", campaign_id, aside(ONE))

    judging, own = [
        (await client.get(f"/identifications/1/readings{of}")).text for of in ("", "?identified_from=true")
    ]

    assert "These readings judge the model and cannot be set aside." in judging
    assert 'data-part="aside"' not in judging and 'data-part="aside"' in own
    assert "1 reading set aside by Ada Byron" in own
    # An imported campaign was measured in no session of this cell.
    assert 'data-part="again"' not in own and 'data-part="csv"' in own
