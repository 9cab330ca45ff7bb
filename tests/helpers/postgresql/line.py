"""The line between a service and a server, which a test can cut around a commit."""

import contextlib
import socket
import threading

_COMMIT = b"COMMIT"
_SOCKET = ".s.PGSQL.5432"


class Line:
    """A socket like the server's in a folder of its own; what comes is passed on until it is cut."""

    def __init__(self, server, folder):
        self._target = str(server.folder / _SOCKET)
        self.folder = folder
        self._cut = None  # "before" or "after" the server has a commit
        self._open = []
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(folder / _SOCKET))
        self._listener.listen()
        self.closed = False
        threading.Thread(target=self._accept, daemon=True).start()

    def cut_next_commit(self, when):
        self._cut = when

    def cut(self):
        """Cut everything that is open, and let nothing new through."""
        self.closed = True
        for end in self._open:
            _shut(end)

    def mend(self):
        self.closed = False

    def close(self):
        self.cut()
        _shut(self._listener)

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                here, _ = self._listener.accept()
                if self.closed:
                    here.close()
                    continue
                there = socket.socket(socket.AF_UNIX)
                there.connect(self._target)
                self._open += [here, there]
                lost = threading.Event()
                threading.Thread(target=self._send, args=(here, there, lost), daemon=True).start()
                threading.Thread(target=self._answer, args=(there, here, lost), daemon=True).start()

    def _send(self, here, there, lost):
        with contextlib.suppress(OSError):
            while data := here.recv(65536):
                when = self._cut if _COMMIT in data else None
                if when is not None:
                    self._cut = None
                    lost.set()
                if when != "before":
                    there.sendall(data)
                if when is not None:
                    break
        if not lost.is_set() or when == "before":
            _shut(there)
            _shut(here)

    def _answer(self, there, here, lost):
        with contextlib.suppress(OSError):
            while data := there.recv(65536):
                if lost.is_set():  # made, and nobody hears of it
                    break
                here.sendall(data)
        _shut(here)
        _shut(there)


def _shut(end):
    with contextlib.suppress(OSError):
        end.shutdown(socket.SHUT_RDWR)
    end.close()
