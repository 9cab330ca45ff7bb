"""What a campaign tells is kept for that campaign, and for no other of its numbers; a bad one fails alone."""

import dataclasses
from unittest.mock import Mock

import numpy as np
import pytest

from tests.helpers.archive import ThisProcess
from tests.helpers.domain.builders import make_campaign
from truepose.analysis.archive import ArchivedCampaign
from truepose.analysis.fleets import comparison
from truepose.analysis.fleets.campaign_summaries import CampaignSummaryService
from truepose.analysis.fleets.campaigns import CampaignEstimate
from truepose.analysis.parallel.tasks import Cluster
from truepose.storage.documents import pack
from truepose.storage.plant.queries import ResultRecord

CAMPAIGN = ResultRecord(
    1, "left arm", "campaign", 1, "spring", "IRB 120", "120-1", "T-1", "2026-03-03", None, branch_id=1
)


class Campaigns:
    async def content(self, campaign):
        return campaign.robot_serial_number.encode()


class Drawing:
    async def draw(self, work, asked):
        return work(asked)


def desk(folder):
    return CampaignSummaryService(
        Campaigns(), CampaignSummaryService.folder(folder / "plant.sqlite3"), Drawing()
    )


async def test_a_plant_that_was_begun_anew_is_not_told_what_another_robot_told(tmp_path, monkeypatch):
    monkeypatch.setattr("truepose.analysis.fleets.campaigns.tell", lambda content, _seed: b"of " + content)

    (first,) = await desk(tmp_path).told([CAMPAIGN])
    (kept,) = await desk(tmp_path).known([CAMPAIGN])
    (other,) = await desk(tmp_path).told([dataclasses.replace(CAMPAIGN, robot_serial_number="120-2")])

    assert (first.told, kept.told, other.told) == (b"of 120-1", b"of 120-1", b"of 120-2")


async def test_a_campaign_at_which_the_program_fails_leaves_the_others_their_answers(tmp_path, monkeypatch):
    def tell(content, _seed):
        if content == b"120-2":
            raise ZeroDivisionError("by 0")
        return b"of " + content

    monkeypatch.setattr("truepose.analysis.fleets.campaigns.tell", tell)
    bad = dataclasses.replace(CAMPAIGN, id=2, robot_serial_number="120-2")

    first, second = await desk(tmp_path).told([CAMPAIGN, bad])

    assert (first.told, second.told) == (b"of 120-1", b"")
    assert "ZeroDivisionError: by 0" in second.why


ESTIMATE = CampaignEstimate(
    robot=make_campaign().robot,
    robot_serial_number="120-1",
    instrument_serial_number="T-1",
    measured_on="2026-03-03",
    simulated=False,
    names=("offset",),
    units=("rad",),
    means=np.zeros(1),
    widths=np.ones(1),
    owners=("joint_offset",),
    normal=np.eye(1),
    right=np.zeros(1),
    motion_mm2=np.eye(1),
    readings=1,
)


@pytest.mark.parametrize("torn", [None, b"", b"half of", pack(ESTIMATE)[:-8]])
def test_what_a_folder_has_is_told_once_and_again_only_where_it_is_torn(tmp_path, monkeypatch, torn):
    monkeypatch.setattr(comparison, "tell", told_of := Mock(return_value=pack(ESTIMATE)))

    for _ in range(2):
        archive = ArchivedCampaign("spring", lambda: b"readings", lambda: None)
        comparison.FleetArchive([archive], kept=tmp_path).tell(Cluster(ThisProcess()), lambda *_: None)
        (kept,) = tmp_path.rglob("*.told")
        assert kept.read_bytes() == pack(ESTIMATE)
        if torn is not None:
            kept.write_bytes(torn)

    assert told_of.call_count == (1 if torn is None else 2)
