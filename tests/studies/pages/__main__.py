"""How heavy each page is and how soon it shows what it is about, on a slow tablet; and what it looks like.

python -m tests.studies.pages --out out/pages
"""

import json
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from playwright.sync_api import Browser, Page, sync_playwright

from tests.browser.pages.house import OF_LINKS, SIGNED_IN, open_house
from tests.browser.pages.looks import LOOKS, Traffic
from tests.browser.pages.shop import open_shop, pages
from tests.studies.running import leave, study_options

_SIZES: Final = {"tablet": (1180, 820), "desktop": (1440, 900), "phone": (390, 844)}
_SLOWER: Final = 4.0  # a tablet of the hall against this computer
_RUNS: Final = 5
# When the largest piece of the page was painted, and nothing larger after it: milliseconds.
_PAINTED: Final = """() => new Promise((done) => new PerformanceObserver((list) =>
  done(list.getEntries().at(-1).startTime)).observe({ type: "largest-contentful-paint", buffered: true }))"""


def measured(browser: Browser, address: str, cookies: list[Any]) -> dict[str, Any]:
    """Return the weight of a page, and when it was painted on a slow tablet: at first, median and worst."""
    painted_s, weight = [], 0
    for _ in range(_RUNS):
        page = browser.new_page(viewport={"width": _SIZES["tablet"][0], "height": _SIZES["tablet"][1]})
        page.context.add_cookies(cookies)
        page.context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": _SLOWER})
        traffic = Traffic(page)
        page.goto(address)
        traffic.settled()
        painted_s.append(page.evaluate(_PAINTED) / 1000)
        weight = traffic.weight
        page.close()
    first_s = painted_s[0]  # what is drawn once was not drawn yet
    painted_s.sort()
    return {
        "weight_kb": weight / 1000,
        "first_s": first_s,
        "painted_s": painted_s[_RUNS // 2],
        "worst_s": painted_s[-1],
        "load": os.getloadavg()[0],
    }


def photographed(page: Page, address: str, file: Path) -> None:
    """Write a picture of a page in each size and look."""
    for size, (width, height) in _SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        for look in LOOKS:
            page.goto(address)
            page.locator("[data-drawing]").wait_for(state="detached")
            page.evaluate("(look) => { document.documentElement.dataset.look = look; }", look)
            page.screenshot(path=file.with_name(f"{file.name}-{size}-{look}.png"))


def every_page(folder: Path) -> Iterator[tuple[str, str, list[Any]]]:
    """Yield the name of each page, its address, and the cookies of whoever looks at it."""
    (folder / "shop").mkdir()
    (folder / "house").mkdir()
    with open_shop(folder / "shop") as url:
        yield from ((place, url + place, []) for place in pages())
    with open_house(folder / "house") as house:
        yield from ((f"signed in{place}", house.address(place), house.cookies) for place in SIGNED_IN)
        yield from ((place, house.address(place), []) for place in OF_LINKS)


def main() -> None:
    """Measure and photograph every page of a shop."""
    asked = study_options(__doc__, out=Path, no_pictures=False)
    asked.out.mkdir(parents=True, exist_ok=True)
    path = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    found = {}
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as drive:
        browser = drive.chromium.launch(executable_path=path, args=["--no-sandbox"])
        for name, address, cookies in every_page(Path(folder)):
            found[name] = measured(browser, address, cookies)
            sys.stdout.write(json.dumps({"page": name, **found[name]}) + "\n")
            sys.stdout.flush()
            if not asked.no_pictures:
                with browser.new_page() as page:
                    page.context.add_cookies(cookies)
                    photographed(page, address, asked.out / (name.strip("/").replace("/", "-") or "cell"))
        browser.close()
    leave(asked.out, "pages", found)


if __name__ == "__main__":
    main()
