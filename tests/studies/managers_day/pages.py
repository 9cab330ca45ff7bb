"""What somebody sees in a browser, kept as pictures."""

import shutil
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Final

from playwright.async_api import Browser, Page, async_playwright

PASSWORD: Final = "on the looms of Lyon"
_PIN: Final = "4071"
_NAMES: Final = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
_SIZE: Final = {"width": 1280, "height": 900}
_PATIENCE_MS: Final = 30_000


class Looking:
    """Somebody at a screen."""

    def __init__(self, browser: Browser, page: Page, out: Path) -> None:
        self._browser, self._page, self._out = browser, page, out
        self._pictures = 0

    async def choose_password(self, link: str) -> None:
        """Follow the link by which somebody new chooses their secrets; they are signed in by it."""
        await self._page.goto(link)
        for field, secret in (("password", PASSWORD), ("repeated", PASSWORD), ("pin", _PIN)):
            await self._page.locator(f"main [name={field}]").fill(secret)
        await self._page.get_by_role("button", name="Set password").click()
        await self._page.wait_for_url(lambda url: "/welcome/" not in url)

    async def at(self, url: str, name: str) -> str:
        """Open a page, keep a picture of it, and return what stands on it."""
        await self._page.goto(url)
        self._pictures += 1
        await self._page.screenshot(path=self._out / f"{self._pictures:02d}-{name}.png", full_page=True)
        return await self._page.locator("body").inner_text()

    async def elsewhere(self, url: str, token: str, name: str) -> str:
        """Open a page of another service in a window of its own, where they are let in by a token."""
        headers = {"Authorization": f"Bearer {token}"}
        context = await self._browser.new_context(viewport=_SIZE, extra_http_headers=headers)
        window = Looking(self._browser, await context.new_page(), self._out)
        window._pictures = self._pictures
        seen = await window.at(url, name)
        self._pictures = window._pictures
        await context.close()
        return seen

    async def links_of_rows(self, heading: str) -> list[tuple[str, list[str]]]:
        """Return text and addresses of each row of the table below a heading of the open page."""
        title = self._page.locator("h2", has_text=heading)
        rows = await title.locator("xpath=following::table[1]").locator("tbody tr").all()
        return [
            (
                " | ".join(" ".join(part.split()) for part in (await row.inner_text()).split("\t")),
                [str(await link.get_attribute("href")) for link in await row.locator("a").all()],
            )
            for row in rows
        ]


@asynccontextmanager
async def looking(out: Path) -> AsyncIterator[Looking]:
    """Yield somebody with a browser."""
    path = next(filter(None, map(shutil.which, _NAMES)))
    async with async_playwright() as playwright:
        # The sandbox needs rights that a container's root user does not have; the pages are our own.
        browser = await playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        page = await browser.new_page(viewport=_SIZE)
        page.set_default_timeout(_PATIENCE_MS)
        yield Looking(browser, page, out)
        await browser.close()
