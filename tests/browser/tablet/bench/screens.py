"""Every screen of a ballbar session, how a page is brought there, and what is measured on it."""

from tests.browser.tablet.bench.fake_desk import ARM_BEFORE, leg, move, sample, scene, step

SUSPICION = {"kind": "other_pair", "asked": ["B2", "T3"], "suspected": ["B1", "T2"]}
DOUBT = {**SUSPICION, "length_mm": 300.1004, "expected_mm": 300.42}
FOREIGN = {
    "device": "ballbar",
    "finding": "foreign",
    "serial_number": "QC20-12A345",
    "expected_serial_number": "QC20-98B761",
    "person": None,
}
STORED = {"step_id": leg(1, 1)["id"], "kind": "measured", "length_mm": 299.8612, "text": ""}
SCREENS = {
    "connect_leg": {"step": leg(), "swaps_can_be_seen": False, "last_outcome": STORED},
    "measure_side": {"step": step("measure_side", artefact="tool", points=["T1", "T2"])},
    "initialise": {"step": step("initialise", artefact="base")},
    "place_base": {"step": step("place_base")},
    "fit_ball": {"step": step("fit_ball")},
    "clamp_cup": {"step": step("clamp_cup", base_point=1)},
    "remove_ball": {"step": step("remove_ball")},
    "detach": {"step": step("detach")},
    "move": {"step": move(), "ballbar_attached": False},
    "moving": {"step": move(), "robot_moving": True},
    "doubt": {"suspicion": DOUBT},
    "precalibrate": {"step": step("precalibrate")},
    "planned": {"state": "planned"},
    "paused": {"state": "paused", "reason": "The pre-calibration failed: measure more poses."},
    "pausing": {"state": "pausing"},
    "interrupted": {"state": "awaiting_confirmation"},
    "foreign": {"state": "awaiting_confirmation", "ballbar_in_question": FOREIGN},
    "finished": {"state": "finished", "step": None},
    "aborted": {"state": "aborted", "step": None},
    "failed": {"state": "failed", "step": None, "reason": "The disk is full."},
}
STATES = {
    "in_range": sample(),
    "out_low": sample("out_low", None),
    "out_high": sample("out_high", None),
    "unstable": sample("unstable", 300.1),
    "no_signal": sample("no_signal", None),
}
UNSEEN = ["planned", "finished", "aborted", "failed"]  # screens without a picture
SIZES = [(320, 568), (390, 844), (844, 390), (1024, 600), (800, 1280), (1280, 800)]
BLOCKS = ".top, .notices, .ask, .picture, .panel, .last, .gauge, .caution, .actions, .dock"
# Blocks that lie on another one, and blocks whose content is larger than they are (a list may scroll).
COVERED = f"""() => {{
  const blocks = [...document.querySelectorAll("{BLOCKS}")].filter((node) => node.offsetHeight);
  const found = [];
  for (const [i, one] of blocks.entries()) {{
    const a = one.getBoundingClientRect();
    const cut = one.scrollHeight > one.clientHeight + 1 && !one.matches(".panel, .picture");
    if (a.bottom > innerHeight + 1 || a.right > innerWidth + 1) found.push(`${{one.className}} sticks out`);
    if (cut) found.push(`${{one.className}} is cut`);
    for (const other of blocks.slice(i + 1)) {{
      const b = other.getBoundingClientRect();
      const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (across > 1 && down > 1) found.push(`${{one.className}} / ${{other.className}}`);
    }}
  }}
  return found;
}}"""
# Contrast of every text with what lies behind it, after WCAG 2.2, 1.4.3; disabled controls are exempt there.
FAINT_TEXTS = """() => {
  const channel = (value) => (value /= 255) <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
  const numbers = (text) => text.match(/[\\d.]+/g).map(Number);
  const behind = (node) => {
    for (; node; node = node.parentElement) {
      const [r, g, b, a = 1] = numbers(getComputedStyle(node).backgroundColor);
      if (a > 0.5) return [r, g, b];
    }
    return [255, 255, 255];
  };
  const said = (node) => [...node.childNodes].some((child) => child.nodeType === 3 && child.data.trim());
  return [...document.querySelectorAll("body *")]
    .filter((node) => node.checkVisibility() && said(node))
    .filter((node) => !node.closest("svg, :disabled, .unseen, script"))
    .map((node) => {
      const ink = light(numbers(getComputedStyle(node).color));
      const [a, b] = [ink, light(behind(node))].sort((x, y) => y - x);
      return [node.textContent, (a + 0.05) / (b + 0.05)];
    })
    .filter(([, contrast]) => contrast < 4.5);
}"""
# What of these buttons is outside of the screen, or lies under something else at its middle or near a corner.
OUT_OF_REACH = """(selector) => {
  const reached = (button, x, y) => button.contains(document.elementFromPoint(x, y));
  return [...document.querySelectorAll(selector)].flatMap((button) => {
    const { left, right, top, bottom } = button.getBoundingClientRect();
    const name = button.textContent.trim();
    const whole = left >= 0 && top >= 0 && right <= innerWidth + 0.5 && bottom <= innerHeight + 0.5;
    if (!whole) return [`${name} sticks out`];
    const across = [left + 12, (left + right) / 2, right - 12];
    const down = [top + 12, (top + bottom) / 2, bottom - 12];
    const free = across.every((x) => down.every((y) => reached(button, x, y)));
    return free ? [] : [`${name} is covered`];
  });
}"""
# The same with every notice open and full; afterwards they are as they were.
OUT_OF_REACH_BELOW_NOTICES = f"""(selector) => {{
  const notices = [...document.querySelectorAll(".notice")];
  const before = notices.map((notice) => [notice.hidden, notice.textContent]);
  for (const notice of notices) {{
    notice.hidden = false;
    notice.textContent = "The service refused this because of something that is long to say. ".repeat(2);
  }}
  const found = ({OUT_OF_REACH})(selector);
  notices.forEach((notice, i) => ([notice.hidden, notice.textContent] = before[i]));
  return found;
}}"""
# All that a screen of one size shows at once.
_LOOK = f"""() => {{
  const names = getComputedStyle(document.querySelector("#names"));
  const warning = document.querySelector("#caution:not([hidden]) strong");
  const box = (node) => {{
    const {{ x, y, width, height }} = node.getBoundingClientRect();
    return [node.className, x, y, width, height];
  }};
  return {{
    dock: [...document.querySelectorAll(".dock button")].map(box),
    heights: [...document.querySelectorAll("#actions button")].map((button) => button.offsetHeight),
    letters: parseFloat(names.fontSize),
    capitals: names.textTransform,
    warning: warning && parseFloat(getComputedStyle(warning).fontSize),
    beyond: document.documentElement.scrollWidth - innerWidth,
    covered: ({COVERED})(),
    faint: ({FAINT_TEXTS})(),
    out_of_reach: ({OUT_OF_REACH_BELOW_NOTICES})("#caution:not([hidden]), #actions button, .dock button"),
  }};
}}"""


def shown(page, desk, screen):
    """Bring the page to a screen and wait until it is there with its picture."""
    if page.locator("body").get_attribute("data-screen") == screen:
        shown(page, desk, next(other for other in SCREENS if other != screen))
    moving = screen in {"move", "moving"}
    desk.scene = scene(before=ARM_BEFORE if moving else None)
    dull = {"state": "running", "step": leg(), "suspicion": None, "robot_moving": False}
    dull["ballbar_in_question"] = None
    desk.show(**{**dull, **SCREENS[screen]})
    page.locator(f"body[data-screen={screen}]").wait_for()
    if screen not in UNSEEN:  # the geometry of a step is fetched after its words
        page.locator("#picture:not([hidden])").wait_for(state="attached")


def resized(page, size):
    page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))


def looked_at(page, size):
    """Measure the screen that is shown, at that size."""
    resized(page, size)
    return page.evaluate(_LOOK)


def drawn(page):
    """Wait until what the page knows is on the screen: it draws once a frame."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done)))")
