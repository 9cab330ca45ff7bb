"""How many pictures a second come while a picture in space is turned on a slow tablet.

python -m tests.studies.pages.turning --out out/pages

A machine without a graphics processor draws them on its processor, which a tablet need not: what a picture
costs the page and what it costs the drawing is said apart, in CPU time that other programs do not change.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Final

from playwright.sync_api import Page, sync_playwright

from tests.browser.pages.shop import open_shop
from tests.studies.processes import cpu_s
from tests.studies.running import leave, study_options

_SLOWER: Final = 4.0
_SECONDS: Final = 3.0
_VIEWS: Final = {"robot-view": "/diagnoses/1?whole=true", "plan-view": "/sessions/1"}
_SOFTWARE: Final = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
_PROCESS: Final = re.compile(r"--type=(gpu-process|renderer)")
_TURNED: Final = """async (seconds) => {
  const canvas = document.querySelector(".space-stage canvas");
  canvas.setPointerCapture = canvas.releasePointerCapture = () => {};
  const { x, y } = canvas.getBoundingClientRect();
  const finger = (type, along) => canvas.dispatchEvent(new PointerEvent(type, {
    pointerId: 1, pointerType: "mouse", bubbles: true, buttons: 1, button: 0,
    clientX: x + 100 + along, clientY: y + 200 }));
  const frame = () => new Promise(requestAnimationFrame);
  finger("pointerdown", 0);
  const begun = await frame();
  let pictures = 0;
  for (let now = begun; now - begun < 1000 * seconds; pictures += 1) {
    finger("pointermove", (5 * pictures) % 400);
    now = await frame();
  }
  finger("pointerup", 0);
  return pictures; }"""


def processes_ms() -> dict[str, int]:
    """Return the CPU time of the page and of what draws, so far [ms]; of our own browser."""
    listed = subprocess.run(["ps", "-eo", "pid,ppid,args"], capture_output=True, text=True, check=True).stdout
    rows = [line.split(None, 2) for line in listed.splitlines()[1:]]
    ours = {str(os.getpid())}
    while grown := {pid for pid, parent, _ in rows if parent in ours} - ours:
        ours |= grown
    spent: dict[str, int] = {}
    for pid, _, command in rows:
        kind = _PROCESS.search(command)
        if kind and pid in ours:
            spent[kind[1]] = spent.get(kind[1], 0) + round(1000 * cpu_s(int(pid)))
    return spent


def turned(page: Page, slower: float) -> dict[str, Any]:
    """Return pictures a second and what each cost, on a processor that much slower."""
    page.context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": slower})
    before = processes_ms()
    pictures = page.evaluate(_TURNED, _SECONDS)
    cost = {name: (ms - before.get(name, 0)) / pictures for name, ms in processes_ms().items()}
    return {
        "slower": slower,
        "pictures_per_s": pictures / _SECONDS,
        "cpu_ms": cost,
        "load": os.getloadavg()[0],
    }


def main() -> None:
    """Turn both kinds of pictures, on screens of one and of two pixels to the page's."""
    asked = study_options(__doc__, out=Path)
    path = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    found = []
    with tempfile.TemporaryDirectory() as folder, open_shop(Path(folder)) as url, sync_playwright() as drive:
        browser = drive.chromium.launch(executable_path=path, args=["--no-sandbox", *_SOFTWARE])
        for view, address in _VIEWS.items():
            for pixels in (1, 2):
                size = {"width": 1180, "height": 820}
                with browser.new_page(viewport=size, device_scale_factor=pixels) as page:
                    page.goto(url + address)
                    page.locator(view).scroll_into_view_if_needed()
                    page.locator(f"{view}[data-ready]").wait_for()
                    found += [
                        {"view": view, "pixels": pixels, **turned(page, slower)} for slower in (1.0, _SLOWER)
                    ]
        browser.close()
    leave(asked.out, "turning", found)
    sys.stdout.writelines(f"{json.dumps(row)}\n" for row in found)


if __name__ == "__main__":
    main()
