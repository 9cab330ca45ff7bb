"""What a page of somebody else can do to a service on the same computer, tried in a browser."""

import contextlib
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

_PAGE = b"<!doctype html><title>evil</title><iframe name=framed></iframe>"
_ATTACKS = """async (base) => {
  const url = `${base}/api/v1/sessions/1/commands`;
  const halts = ["pause", "abort"].map((command) => JSON.stringify({ command }));
  const told = [];
  for (const mode of ["no-cors", "cors"])
    for (const type of ["text/plain", "application/x-www-form-urlencoded", "application/json"])
      for (const body of halts)
        await fetch(url, { method: "POST", mode, headers: { "Content-Type": type }, body }).catch(() => 0);
  for (const body of halts) {
    await fetch(url, { method: "POST", mode: "no-cors", body }).catch(() => 0);
    navigator.sendBeacon(url, new Blob([body], { type: "text/plain" }));
    const form = document.createElement("form");
    Object.assign(form, { method: "POST", action: url, target: "framed", enctype: "text/plain" });
    const [name, value] = [body.slice(0, -1) + ', "reason": "', '"}']; // as a form makes JSON of plain text
    form.append(Object.assign(document.createElement("input"), { name, value }));
    document.body.append(form);
    form.submit();
  }
  for (const [name, attribute, url] of [["img", "src", "/api/v1/events"], ["script", "src", "/openapi.json"],
      ["iframe", "src", "/operator"], ["object", "data", "/operator"], ["embed", "src", "/"]]) {
    const element = document.createElement(name);
    await new Promise((done) => {
      element.onload = () => (told.push(`${name} loaded`), done());
      element.onerror = () => done();
      element.setAttribute(attribute, base + url);
      document.body.append(element);
      setTimeout(done, 1000);
    });
  }
  await fetch(`${base}/api/v1/sessions`).then((reply) => told.push(`read ${reply.status}`)).catch(() => 0);
  return told;
}"""


class _Page(BaseHTTPRequestHandler):
    def do_GET(self):  # the library's name
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(_PAGE)

    def log_message(self, *args):
        pass


@contextlib.contextmanager
def somebody_elses_server():
    with ThreadingHTTPServer(("127.0.0.1", 0), _Page) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            yield server.server_address[1]
        finally:
            server.shutdown()
            thread.join()


def test_a_page_of_others_neither_presses_nor_reads_nor_frames(chromium, service):
    session = service.paused_session("left arm")

    told = []
    for site in ("evil.test", "localhost", "127.0.0.1"):
        with somebody_elses_server() as port, chromium.one(f"http://{site}:{port}") as page:
            page.goto(f"http://{site}:{port}/")
            told += page.evaluate(_ATTACKS, service.url)

    assert service.get(session)["state"] == "paused"  # not aborted
    # A frame that was refused "loads" an error of the browser's own; nothing that was read came through.
    assert not [what for what in told if what.startswith(("read", "script", "img"))]


def test_a_name_that_leads_here_is_answered_with_a_refusal_only(chromium, service):
    port = service.url.rpartition(":")[2]
    with chromium.one(f"http://evil.test:{port}") as page:
        reply = page.goto(f"http://evil.test:{port}/operator")
        # The refusal itself lets nothing be fetched.
        fetched = page.evaluate("fetch('/api/v1/sessions').then((r) => r.status, () => 'not allowed')")

    assert reply.status == 421
    assert fetched == "not allowed"
