"""Faults on order: a real cell has none, and what the desk passes on to a simulated one."""

import pytest

from truepose.messages.catalogue import LANGUAGES, catalogue
from truepose.sessions.cell import CurrentCell
from truepose.sessions.errors import FaultRefusedError, PersonMissingError
from truepose.sessions.simulated import FaultService
from truepose_simulators.faults.kinds import KINDS

WANTED = {"person": "Ada", "kind": "link_cut", "keys": {"device": "robot", "for_s": 8.0}}


class FakeCell:
    """Takes every fault but the flood."""

    def __init__(self):
        self.asked = []

    async def ask(self, request):
        self.asked.append(request)
        if request["op"] == "list":
            return {"now_s": 3.0, "faults": [{"number": 1}, {"number": 2}]}
        return {"error": 'key "kind" must be another'} if request.get("kind") == "flood" else {"number": 2}


async def test_on_a_real_cell_nothing_goes_wrong_on_order(client):
    found = (await client.get("/api/v1/simulated-faults")).json()
    refused = await client.post("/api/v1/simulated-faults", json=WANTED)
    page = await client.get("/faults?language=fr")

    assert (found["simulated"], found["kinds"], found["faults"]) == (False, [], [])
    assert refused.status_code == 409
    assert refused.json()["detail"] == "Faults can be triggered only in a simulated cell; this one is real."
    assert "Cette cellule est réelle" in page.text
    assert "<form" not in page.text


async def test_who_gave_a_fault_is_remembered_and_what_the_cell_refuses_is_said():
    cell = FakeCell()
    desk = FaultService(cell.ask, CurrentCell())

    number = await desk.give(" Ada ", "link_cut", {"device": "robot", "op": "end"})
    with pytest.raises(FaultRefusedError, match="must be another"):
        await desk.give("Ada", "flood", {})
    given = await desk.given()

    assert number == 2
    assert cell.asked[0] == {"op": "give", "kind": "link_cut", "device": "robot"}
    assert [fault["person"] for fault in given["faults"]] == [None, "Ada"]


async def test_nobody_without_a_name_gives_or_ends_one():
    cell = FakeCell()
    desk = FaultService(cell.ask, CurrentCell())

    for act in (desk.give("\u200b", "link_cut", {}), desk.end("", 1)):
        with pytest.raises(PersonMissingError):
            await act

    assert cell.asked == []


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_kind_has_its_words(language):
    words = catalogue(language)

    assert [kind for kind in KINDS if words.name(kind) == kind] == []
    assert [kind for kind in KINDS if words.name(kind, "meaning") == words.name(kind)] == []
