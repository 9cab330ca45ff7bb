"""An open_abb server that lives in memory, and the driver that speaks to it."""

import math

from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.abb_open_abb.driver import OpenAbbRobot, TimeOuts
from truepose_drivers.abb_open_abb.protocol import (
    decode_request,
)
from truepose_drivers.api import MotionLimits

QUICK = TimeOuts(connect_s=0.05, retry_s=0.01, reply_s=0.05, motion_s=0.05, rest_of_reply_s=0.01)
# The longest motion of the driver's argument takes 2e4 / 1e6 s = 0.02 s at this speed.
FAST = MotionLimits(tool_speed_mm_s=1e6, orientation_speed_rad_s=1e3)
HANG_UP = None
TARGET = (0.1, -0.2, 0.3, 0.0, math.pi / 4, -1.0)


class FakeController:
    """Replies from a table and records the requests as text."""

    def __init__(self, **replies: object) -> None:
        self.replies: dict[int, object] = {0: "0 1 ", 2: "2 1 ", 6: "6 1 ", 7: "7 1 ", 8: "8 1 ", 9: "9 1 "}
        self.replies |= {4: "4 1 10.00 -20.55 30.00 0.00 45.00 -0.01", 98: "98 1 120-1*6.08*IRB 120"}
        self.replies |= {int(code.removeprefix("code_")): reply for code, reply in replies.items()}
        self.requests: list[str] = []

    async def serve(self, end: MemoryEnd) -> None:
        pending = b""
        while data := await end.receive():
            pending += data
            if b"#" not in pending:
                continue
            self.requests.append(pending.decode())
            reply = self.replies.get(decode_request(pending).code, "")
            pending = b""
            if reply is HANG_UP:
                return
            if reply:
                await self.say(end, str(reply))

    async def say(self, end: MemoryEnd, reply: str) -> None:
        await end.send(reply.encode())


async def connected_robot(fake: FakeController, chunk_bytes: int = 4096) -> OpenAbbRobot:
    robot = OpenAbbRobot(MemoryLink(fake.serve, chunk_bytes=chunk_bytes), FixedClock(), time_outs=QUICK)
    await robot.connect()
    fake.requests.clear()
    return robot


def codes(fake: FakeController) -> list[str]:
    """What was asked, in order; a ping looks for the end of a reply."""
    return [request.split()[0] for request in fake.requests]


PLAIN_TOOL = ["6 0.0 0.0 0.0 1 0 0 0 #", "7 0 0 0 1 0 0 0 #"]
LIMITS = ["6", "7", "8", "9"]
OURS = {"code_98": "98 1 120-1*6.08*IRB 120*truepose 3", "code_95": "95 1 "}
