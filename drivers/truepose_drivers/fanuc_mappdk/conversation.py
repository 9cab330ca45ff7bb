"""One of the two ports of a MAPPDK server: the greeting, and one exchange at a time.

Nothing ends a reply but its form. What may still go on is waited for, and an error in words that are not
known is followed by a new connection: the rest of it must not be taken for the next reply.
"""

from truepose_drivers.errors import ConnectFailedError, NoReplyError
from truepose_drivers.fanuc_mappdk import protocol
from truepose_drivers.transports.conversation import Turns
from truepose_drivers.transports.link import Link, drain, now_s


class Dialogue(Turns):
    """Questions to one port and their replies."""

    def __init__(self, link: Link, *, greeting_s: float, rest_of_reply_s: float) -> None:
        super().__init__(link)
        self._link = link
        self._greeting_s = greeting_s
        self._rest_of_reply_s = rest_of_reply_s  # how long the end of a reply in unknown words may lag behind

    async def open(self) -> None:
        """Connect and be greeted; raises ConnectFailedError, also where another client is served."""
        await self._link.open()
        try:
            async with self.turn():
                greeting = await self._reply("success", self._greeting_s, beats=False)
                if greeting != protocol.GREETING:
                    raise protocol.MappdkProtocolError(
                        f"{self.address} greets with {greeting.message[:40]!r}"
                    )
        except NoReplyError as error:
            raise ConnectFailedError(
                f"{self.address} sends no greeting: another client is connected, or it is not a MAPPDK server"
            ) from error

    async def ask(
        self, request: bytes, expected: protocol.Expected, timeout_s: float, *, beats: bool = False
    ) -> protocol.Reply:
        """Send a request and return its reply; with `beats` the server hears meanwhile that somebody waits.

        Raises NoReplyError after `timeout_s` [s, wall time].
        """
        async with self.turn():
            await drain(self._link)  # a line end or the like behind the last reply
            await self._link.send(request)
            reply = await self._reply(expected, timeout_s, beats=beats)
            protocol.require(reply, expected)
            behind = await self._link.receive(0.0) if self._link.is_open else None
            if behind is not None and behind.strip():
                raise protocol.MappdkProtocolError(
                    f"the robot sent more data than requested ({behind[:40]!r}): connect again"
                )
            return reply

    async def _reply(self, expected: protocol.Expected, timeout_s: float, *, beats: bool) -> protocol.Reply:
        data = await self._whole(expected, timeout_s, beats=beats)
        reply = protocol.decode_reply(data)
        if protocol.reply_extent(data, expected) == "maybe whole":
            await self._link.close()
        return reply

    async def _whole(self, expected: protocol.Expected, timeout_s: float, *, beats: bool) -> bytes:
        deadline_s = now_s() + timeout_s
        data = b""
        while (extent := protocol.reply_extent(data, expected)) != "whole":
            left_s = deadline_s - now_s()
            patience_s = self._rest_of_reply_s if extent == "maybe whole" else left_s
            more = await self._link.receive(
                max(min(patience_s, protocol.BEAT_S) if beats else patience_s, 0.0)
            )
            if more is not None:
                data += more
            elif extent == "maybe whole":
                return data
            elif beats and left_s > protocol.BEAT_S:
                await self._link.send(protocol.BEAT)
            else:
                raise NoReplyError(f"the robot at {self.address} is connected but does not respond")
        return data
