"""A bridge to a tracker that only its maker's software can drive: fill in `Instrument`, and start it.

    python instrument_bridge.py --port 7421

It needs nothing but Python and the maker's programming kit; the cell file names the driver `json_bridge`.
"""

import argparse
import json
import random
import socketserver
import sys
import threading
import time
from typing import Any


class InstrumentError(Exception):
    """What cannot be done: one of the words of the protocol, and a sentence for the operator."""

    def __init__(self, word: str, sentence: str) -> None:
        super().__init__(sentence)
        self.word = word


class Instrument:
    """Put the calls of the maker's kit here: millimetres, radians, the instrument's own frame.

    As it stands it plays a tracker of points with one reflector; leave out what yours cannot do.
    """

    serial = "12345"
    reflector_mm = (2000.0, 300.0, -150.0)

    def hello(self) -> dict[str, Any]:
        """Say what instrument this is."""
        return {"manufacturer": "FARO", "model": "Vantage", "firmware": "6.1"}

    def initialise(self) -> dict[str, Any]:
        """Make it ready, and say what it measures with."""
        return {"settings": "The tracker measures an SMR of 1.5 in, absolute distances, profile standard."}

    def find_reflector(self, near_mm: list[float], radius_mm: float) -> dict[str, Any]:
        """Point there, and lock on the reflector within the radius."""
        off = max(abs(a - b) for a, b in zip(near_mm, self.reflector_mm, strict=True))
        if off > radius_mm:
            raise InstrumentError("reflector_not_found", "no reflector there: check that it is in its nest")
        return {}

    def measure_point(self, duration_s: float) -> dict[str, Any]:
        """Average over that time."""
        time.sleep(duration_s)
        point_mm = [random.gauss(value, 0.01) for value in self.reflector_mm]
        return {"point_mm": point_mm, "deviation_mm": [0.01, 0.01, 0.01], "samples": 100}


class Bridge(socketserver.StreamRequestHandler):
    """Answers truepose's questions one after the other; says twice a second that it is still at one."""

    instrument = Instrument()

    def handle(self) -> None:
        """Serve one program until it leaves."""
        for line in self.rfile:
            question = json.loads(line)
            number, ask = question.pop("id"), question.pop("ask")
            done = threading.Event()
            waiting = threading.Thread(target=self._say_busy, args=(number, done))
            waiting.start()
            try:
                answer = self._answer(ask, question)
            finally:
                done.set()
                waiting.join()  # nothing is said after the answer
            self._say({"id": number, **answer})

    def _answer(self, ask: str, details: dict[str, Any]) -> dict[str, Any]:
        method = getattr(self.instrument, ask, None)
        if method is None:
            return {"error": "refused", "sentence": f"this instrument offers no {ask}"}
        try:
            values = method(**details)
        except InstrumentError as error:
            return {"error": error.word, "sentence": str(error)}
        # The clock counts measurements, also after a new start: a number that comes again is told as frozen.
        counted = {"unit": "mm", "version": 1, "sequence": time.time_ns() // 1_000}
        return {"serial": self.instrument.serial, **counted, **values}

    def _say_busy(self, number: int, done: threading.Event) -> None:
        while not done.wait(0.5):
            self._say({"id": number, "busy": True})

    def _say(self, message: dict[str, Any]) -> None:
        self.wfile.write(json.dumps(message, allow_nan=False).encode() + b"\n")


def main() -> None:
    """Listen, and serve one program at a time."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on")
    parser.add_argument("--port", type=int, default=7421, help="port to listen on; 0: any")
    options = parser.parse_args()
    with socketserver.TCPServer((options.host, options.port), Bridge) as server:
        sys.stderr.write(f"listening on port {server.server_address[1]}\n")
        sys.stderr.flush()
        server.serve_forever()


if __name__ == "__main__":
    main()
