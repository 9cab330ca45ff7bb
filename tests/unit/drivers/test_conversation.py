"""Exchanges with a device: one at a time, and no answer taken for that to another question."""

import asyncio
from collections import deque

import pytest

from truepose_drivers.errors import ConnectionLostError, DeviceRefusedError, NoReplyError, RemoteProtocolError
from truepose_drivers.framing import LineReader
from truepose_drivers.transports.conversation import Conversation, Turns

pytestmark = pytest.mark.simulated_time

SILENCE = "the gauge says nothing: check its battery"


class FakeLink:
    """A device that has sent `pieces`, and answers each question with what `answers` says."""

    address = "the bench"

    def __init__(self, *pieces: bytes, answers: tuple[bytes, ...] = (), ends: bool = False) -> None:
        self.pieces = deque(pieces)
        self.answers = deque(answers)
        self.ends = ends
        self.is_open = True

    async def open(self) -> None:
        self.is_open = True

    async def close(self) -> None:
        self.is_open = False

    async def send(self, data: bytes) -> None:
        if self.answers:
            self.pieces.append(self.answers.popleft())

    async def receive(self, timeout_s: float) -> bytes | None:
        if self.pieces:
            return self.pieces.popleft()
        if self.ends:
            raise ConnectionLostError("the bench is gone")
        await asyncio.sleep(timeout_s)
        return None


class ChattyLink(FakeLink):
    """A device that sends `word` on and on."""

    def __init__(self, word: bytes) -> None:
        super().__init__()
        self.word = word

    async def receive(self, timeout_s: float) -> bytes | None:
        await asyncio.sleep(0.001)
        return self.word


def conversation_on(link: FakeLink) -> Conversation[bytes]:
    return Conversation(link, LineReader, harmless=(DeviceRefusedError,))


async def ask(conversation: Conversation[bytes], decode=bytes.decode, timeout_s: float = 1.0) -> str:
    return await conversation.ask(b"how long?\n", decode, timeout_s=timeout_s, silence=SILENCE)


def refuse(line: bytes) -> str:
    raise DeviceRefusedError(line.decode())


async def test_a_second_exchange_waits_for_the_first():
    turns, order = Turns(FakeLink()), []

    async def exchange(name: str) -> None:
        async with turns.turn():
            order.append(f"{name} begins")
            await asyncio.sleep(0)
            order.append(f"{name} ends")

    await asyncio.gather(exchange("first"), exchange("second"))

    assert order == ["first begins", "first ends", "second begins", "second ends"]
    assert not turns.taken


async def test_an_exchange_that_was_abandoned_closes_the_connection():
    link = FakeLink()
    waiting = asyncio.create_task(ask(conversation_on(link), timeout_s=60.0))
    await asyncio.sleep(0)

    waiting.cancel()
    await asyncio.gather(waiting, return_exceptions=True)

    assert not link.is_open


@pytest.mark.parametrize(("decode", "stays"), [(refuse, True), (int, False)])
async def test_a_refusal_leaves_the_connection_and_nonsense_closes_it(decode, stays):
    link = FakeLink(answers=(b"beyond its range\n",))

    with pytest.raises((DeviceRefusedError, ValueError)):
        await ask(conversation_on(link), decode)

    assert link.is_open is stays


@pytest.mark.parametrize("chunk_bytes", [1, 2, 6])
async def test_an_answer_is_whole_whatever_pieces_it_comes_in(chunk_bytes):
    answer = b"12.5\n"
    link = FakeLink(*(answer[at : at + chunk_bytes] for at in range(0, len(answer), chunk_bytes)))
    conversation = conversation_on(link)

    conversation.expect(1.0, SILENCE)

    assert await conversation.next() == b"12.5"


async def test_silence_is_told_in_the_instruments_own_sentence():
    link = FakeLink()

    with pytest.raises(NoReplyError, match=SILENCE):
        await ask(conversation_on(link), timeout_s=0.0)

    assert not link.is_open


async def test_one_that_goes_on_sending_and_ends_no_message_is_silent_too():
    conversation = conversation_on(ChattyLink(b"\0"))
    conversation.expect(0.1, SILENCE)

    with pytest.raises(NoReplyError, match=SILENCE):
        await conversation.next()


async def test_what_came_unasked_is_not_the_answer():
    link = FakeLink(b"99.9\n", b"99", answers=(b"12.5\n",))

    assert await ask(conversation_on(link)) == "12.5"


async def test_a_message_that_had_begun_is_no_part_of_the_answer():
    link = FakeLink(b"9", answers=(b"12.5\n",))
    conversation = conversation_on(link)
    assert not await conversation.is_quiet()

    assert await ask(conversation) == "12.5"


@pytest.mark.parametrize("behind", [b"12.5\n", b"1"])
async def test_where_more_comes_than_was_asked_nobody_knows_which_is_the_answer(behind):
    link = FakeLink(answers=(b"12.5\n" + behind,))

    with pytest.raises(RemoteProtocolError, match="more data than requested"):
        await ask(conversation_on(link))

    assert not link.is_open


async def test_what_is_here_is_taken_without_waiting_for_more():
    conversation = conversation_on(FakeLink(b"1\n2\n3", b"\n4"))

    assert [line async for line in conversation.arrived()] == [b"1", b"2", b"3"]
    assert conversation.inside_message


async def test_of_a_device_that_has_said_nothing_nothing_is_here():
    conversation = conversation_on(FakeLink())

    assert [line async for line in conversation.arrived()] == []
    assert await conversation.is_quiet()


async def test_whoever_does_not_stop_sending_is_no_device_of_ours():
    conversation = conversation_on(ChattyLink(b"1\n"))

    with pytest.raises(RemoteProtocolError, match="does not stop sending"):
        async for _ in conversation.arrived():
            pass


async def test_what_stands_behind_a_message_is_kept_for_the_next():
    conversation = conversation_on(FakeLink(b"1\n", b"2\n"))
    conversation.expect(1.0, SILENCE)
    await conversation.next()

    assert not await conversation.is_quiet()

    assert await conversation.next() == b"2"


@pytest.mark.parametrize(("begun", "where"), [((b"12",), "middle of a message"), ((), "is gone$")])
async def test_a_connection_that_ends_says_whether_a_message_had_begun(begun, where):
    conversation = conversation_on(FakeLink(*begun, ends=True))
    conversation.expect(1.0, SILENCE)

    with pytest.raises(ConnectionLostError, match=where):
        await conversation.next()


async def test_opened_again_it_listens_afresh():
    link = FakeLink(b"12")
    conversation = conversation_on(link)
    assert not await conversation.is_quiet()
    await conversation.close()

    await conversation.open()

    assert await conversation.is_quiet()
    assert conversation.is_open
