"""A simulated emScon server that is asked in bytes, and the packets it answers with, packed by hand."""

import struct

from truepose_drivers.leica_emscon.protocol import FrameReader, decode_request, encode
from truepose_simulators.instruments.leica_emscon.conversation import Dialogue
from truepose_simulators.instruments.leica_emscon.settings import CutShort, HangUp, Wait
from truepose_simulators.instruments.tracker import in_tracker_frame

OK, NOT_IMPLEMENTED, NO_DISTANCE, NOT_INITIALIZED = 0, 2, 37, 39
MILLIMETER, METER, INCH = 1, 0, 5


class Server:
    """Feeds bytes to a dialogue and collects what it sends, letting cell time go by."""

    def __init__(self, cell):
        self.cell = cell
        self.dialogue = Dialogue(cell)

    async def ask(self, command, members=b""):
        """Return all packets that follow a request, as bytes."""
        reader = FrameReader()
        reader.receive_data(struct.pack("<iII", 12 + len(members), 0, command) + members)
        sent = []
        for step in self.dialogue.handle(decode_request(reader.next_message())):
            if isinstance(step, Wait):
                await self.cell.clock.sleep(step.duration_s)
            elif isinstance(step, CutShort | HangUp):
                sent.append(step)
            else:
                sent.append(encode(step))
        return sent

    async def start(self, length_unit=MILLIMETER):
        await self.ask(5, struct.pack("<5i", length_unit, 0, 0, 0, 0))
        await self.ask(7)

    async def go_to_fixed_nest(self, number=1):
        target = in_tracker_frame(self.cell.tracker.frame, self.cell.fixed_nests_mm()[number - 1])
        return await self.ask(55, struct.pack("<3di", *target, 1))


def answer(command, status=OK, members=b""):
    return struct.pack("<iIII", 16 + len(members), 0, command, status) + members


def error(command, status):
    return struct.pack("<iIII", 16, 1, command, status)


def event(code):
    return struct.pack("<iII", 12, 8, code)
