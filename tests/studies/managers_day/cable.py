"""The cable between a plant and a cell, which somebody can pull."""

import asyncio
import contextlib

_PART = 4096


class Cable:
    """Passes on what comes at a port of its own, as long as it is plugged in."""

    def __init__(self, port: int, to_port: int) -> None:
        self.port, self._to_port = port, to_port
        self._server: asyncio.Server | None = None
        self._plugged = asyncio.Event()
        self._plugged.set()
        self._ends: set[asyncio.StreamWriter] = set()
        self._cut_after: int | None = None  # bytes of an answer
        self.cuts = 0

    async def plug_in(self, cut_after: int | None = None) -> None:
        """Let everything through; what waited in the dark goes on, as TCP sends it again.

        A bad cable cuts a connection in the middle of an answer once it has brought `cut_after` bytes.
        """
        self._cut_after = cut_after
        self._plugged.set()
        if self._server is None:
            self._server = await asyncio.start_server(self._passed_on, "127.0.0.1", self.port)

    def pull(self) -> None:
        """Let nothing through, and tell nobody: connections stay open and say nothing any more."""
        self._plugged.clear()

    async def switch_off(self) -> None:
        """Have connections end, and new ones refused, as where the computer behind it is off."""
        if self._server is not None:
            self._server.close()
            self._server = None
        for end in {*self._ends}:
            end.transport.abort()
        self._plugged.set()

    async def _passed_on(self, here: asyncio.StreamReader, back: asyncio.StreamWriter) -> None:
        self._ends.add(back)
        try:
            there, forth = await asyncio.open_connection("127.0.0.1", self._to_port)
            self._ends.add(forth)
            asked = asyncio.create_task(self._pass(here, forth, answers=False))
            await self._pass(there, back, answers=True)
            asked.cancel()
            forth.transport.abort()
            self._ends.discard(forth)
        except OSError:
            pass  # nobody is there: the computer refuses
        finally:
            back.transport.abort()
            self._ends.discard(back)

    async def _pass(self, come: asyncio.StreamReader, go: asyncio.StreamWriter, *, answers: bool) -> None:
        passed = 0
        with contextlib.suppress(OSError):
            while data := await come.read(_PART):
                await self._plugged.wait()
                passed += len(data)
                if answers and self._cut_after is not None and passed > self._cut_after:
                    self.cuts += 1
                    return
                go.write(data)
                await go.drain()
        go.transport.abort()
