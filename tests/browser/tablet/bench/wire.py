"""The shop's Wi-Fi between a tablet and the service: it can be lost, in silence, and come back."""

import contextlib
import select
import socket
import threading
import time
from urllib.parse import urlsplit

_CHUNK = 65536
_LOOK_S = 0.02


class Wire:
    """Carries bytes both ways until it is told not to."""

    def __init__(self, url):
        self.leads_to(url)
        self._up = self._down = True
        self._ending = self._late = False
        self._pairs = []
        self._dead = set()  # tablets' ends that carry no more
        self._carriers = []
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

    def roam(self):
        """Carry what is new; what is open now stays dead without a word, as behind another access point."""
        with self._lock:
            self._dead.update(tablet for tablet, _ in self._pairs)

    def delay(self):
        """Deliver nothing before `heal`, and then all of it, also of a tablet that has hung up meanwhile."""
        self._late = True

    def heal(self):
        """Carry again; what hung in the air comes to its end, unless it was only late."""
        if self._late:
            self._late = False
            return
        with self._lock:
            for pair in self._pairs:
                _close(pair)
            self._pairs.clear()
        self._up = self._down = True

    def serve(self, listener):
        """Accept what comes at `listener`, in a thread of its own, until the wire's end."""
        listener.settimeout(_LOOK_S)
        self._serving = threading.Thread(target=self._serve, args=(listener,))
        self._serving.start()

    def _serve(self, listener):
        while not self._ending:
            with contextlib.suppress(TimeoutError):
                tablet, _ = listener.accept()
                service = self._reached(tablet)
                if service is None:
                    continue
                self._carried(tablet, service)

    def end(self):
        """Carry no more; returns once every connection is closed, also one that was just being accepted."""
        self._ending = True
        self._serving.join()
        self.heal()
        for carrier in self._carriers:
            carrier.join()

    def _reached(self, tablet):
        """Connect with the service; one that is being restarted refuses, and the tablet tries again."""
        try:
            return socket.create_connection(self._target)
        except OSError:
            tablet.close()
            return None

    def _carried(self, tablet, service):
        with self._lock:
            self._pairs.append((tablet, service))
        self._carriers.append(threading.Thread(target=self._carry, args=(tablet, service)))
        self._carriers[-1].start()

    def _carry(self, tablet, service):
        try:
            with contextlib.suppress(OSError, ValueError):  # closed by `heal`, or reset by an end
                while not self._ending and self._passed(tablet, service):
                    pass
        finally:
            _close((tablet, service))

    def _passed(self, tablet, service):
        """Pass on what has come; returns whether both ends are still there."""
        if self._late:
            time.sleep(_LOOK_S)
            return True
        for source in select.select([tablet, service], [], [], _LOOK_S)[0]:
            if not (data := source.recv(_CHUNK)):
                return False
            carries = self._up if source is tablet else self._down
            if carries and tablet not in self._dead:
                (service if source is tablet else tablet).sendall(data)
        return True


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
        wire.serve(listener)
        try:
            yield wire, f"http://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            wire.end()
