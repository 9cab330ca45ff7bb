"""The shop's Wi-Fi between a tablet and the service: it can be lost, in silence, and come back."""

import contextlib
import select
import socket
import threading
from urllib.parse import urlsplit

_CHUNK = 65536
_LOOK_S = 0.02


class Wire:
    """Carries bytes both ways until it is told not to."""

    def __init__(self, url):
        self.leads_to(url)
        self._up = self._down = True
        self._ending = False
        self._pairs = []
        self._lock = threading.Lock()

    def leads_to(self, url):
        """Connect with the service at `url` from now on."""
        where = urlsplit(url)
        self._target = (where.hostname, where.port)

    def cut(self):
        """Lose whatever is sent, without a word to either end."""
        self._up = self._down = False

    def lose_answers(self):
        """Carry what the tablet says, lose what the service answers."""
        self._down = False

    def heal(self):
        """Carry again; what hung in the air comes to its end."""
        with self._lock:
            for pair in self._pairs:
                _close(pair)
            self._pairs.clear()
        self._up = self._down = True

    def serve(self, listener):
        listener.settimeout(_LOOK_S)
        while not self._ending:
            with contextlib.suppress(TimeoutError):
                tablet, _ = listener.accept()
                service = self._reached(tablet)
                if service is None:
                    continue
                self._pairs.append((tablet, service))
                threading.Thread(target=self._carry, args=(tablet, service), daemon=True).start()

    def end(self):
        self._ending = True
        self.heal()

    def _reached(self, tablet):
        """Connect with the service; one that is being restarted refuses, and the tablet tries again."""
        try:
            return socket.create_connection(self._target)
        except OSError:
            tablet.close()
            return None

    def _carry(self, tablet, service):
        with contextlib.suppress(OSError, ValueError):  # closed by `heal`
            while True:
                for source in select.select([tablet, service], [], [], _LOOK_S)[0]:
                    data = source.recv(_CHUNK)
                    if not data:
                        return _close((tablet, service))
                    if self._up if source is tablet else self._down:
                        (service if source is tablet else tablet).sendall(data)


def _close(pair):
    for end in pair:
        with contextlib.suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)
        end.close()


@contextlib.contextmanager
def wire_to(url):
    """Yield a wire to the service at `url`, and the URL at this end of it."""
    wire = Wire(url)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=wire.serve, args=(listener,))
        thread.start()
        try:
            yield wire, f"http://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            wire.end()
            thread.join()
