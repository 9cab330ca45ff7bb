"""What follows from records is drawn once."""

import asyncio

import pytest

from truepose.analysis import page_services
from truepose.analysis.page_services import RenderCache
from truepose.domain.errors import TrueposeError
from truepose.storage.caches import DrawnFolder


class Artist:
    """Draws once it is let to, and counts."""

    def __init__(self):
        self.times = 0
        self.may = asyncio.Event()
        self.may.set()

    async def __call__(self):
        self.times += 1
        await self.may.wait()
        return f"picture {self.times}"


@pytest.fixture
def artist():
    return Artist()


@pytest.fixture
def folder(tmp_path):
    return DrawnFolder(tmp_path / "drawn", room_bytes=0)


@pytest.fixture
def drawings(folder):
    return RenderCache(folder)


async def test_what_was_drawn_is_kept_also_for_the_next_service(drawings, folder, artist):
    first = await drawings.drawn("model 1", artist)
    again = await RenderCache(folder).drawn("model 1", artist)

    assert first.body == b"picture 1"
    assert again == first
    assert artist.times == 1


async def test_two_who_ask_at_once_share_a_drawing(drawings, artist):
    artist.may.clear()
    asked = asyncio.gather(*(drawings.drawn("model 1", artist) for _ in range(2)))
    artist.may.set()

    assert [drawn.body for drawn in await asked] == [b"picture 1", b"picture 1"]


async def test_another_record_and_another_version_of_the_program_are_drawn_anew(
    drawings, artist, monkeypatch
):
    await drawings.drawn("model 1", artist)
    other = await drawings.drawn("model 2", artist)
    monkeypatch.setattr(page_services, "program_sha256", lambda: "the next version")
    newer = await drawings.drawn("model 1", artist)

    assert (other.body, newer.body) == (b"picture 2", b"picture 3")


async def test_who_goes_away_leaves_the_drawing_to_the_next(drawings, artist):
    artist.may.clear()
    gone = asyncio.create_task(drawings.drawn("model 1", artist))
    while not artist.times:
        await asyncio.sleep(0)
    gone.cancel()
    await asyncio.gather(gone, return_exceptions=True)
    artist.may.set()

    assert (await drawings.drawn("model 1", artist)).body == b"picture 1"


async def test_what_cannot_be_drawn_is_told_and_tried_again(drawings, artist):
    async def refuse():
        raise TrueposeError("no figures")

    with pytest.raises(TrueposeError, match="no figures"):
        await drawings.drawn("model 1", refuse)

    assert (await drawings.drawn("model 1", artist)).body == b"picture 1"


async def test_a_service_that_ends_gives_up_what_is_being_drawn(drawings, artist):
    artist.may.clear()
    drawing = drawings.drawing("model 1", artist)

    await drawings.close()

    assert drawing.cancelled()
