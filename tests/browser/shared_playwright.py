"""Playwright that stays between files of tests, some of which have loops of their own."""

import asyncio
import contextlib

from playwright.sync_api import sync_playwright


class SharedPlaywright:
    """Begins with its context and is used within `in_use` alone.

    Between two calls it says that its loop runs in this thread, so that asyncio begins no other one there.
    While it is not in use, it does not say so.
    """

    def __enter__(self):
        self._entered = sync_playwright()
        self._playwright = self._entered.start()
        self._loop = asyncio.get_running_loop()
        asyncio._set_running_loop(None)
        return self

    @contextlib.contextmanager
    def in_use(self):
        asyncio._set_running_loop(self._loop)
        try:
            yield self._playwright
        finally:
            asyncio._set_running_loop(None)

    def __exit__(self, *_):
        with self.in_use():
            self._playwright.stop()
