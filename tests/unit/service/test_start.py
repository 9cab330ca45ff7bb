"""How a process begins: what it says can be read, whatever the computer is set up for."""

import io
import sys

import pytest

from truepose.start import speak_unicode

SAID = "精度 0.1 mm, café"


@pytest.mark.parametrize(
    ("platform", "encoding", "written"),
    [
        ("win32", "cp1252", SAID.encode()),
        ("linux", "latin-1", b"\\u7cbe\\u5ea6 0.1 mm, caf\xe9"),
        ("linux", "ascii", b"\\u7cbe\\u5ea6 0.1 mm, caf\\xe9"),
        ("darwin", "utf-8", SAID.encode()),
    ],
)
@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_every_language_can_be_said_into_a_pipe(monkeypatch, stream, platform, encoding, written):
    pipe = io.BytesIO()
    monkeypatch.setattr(sys, stream, io.TextIOWrapper(pipe, encoding=encoding, errors="strict"))
    monkeypatch.setattr(sys, "platform", platform)

    speak_unicode()
    said = getattr(sys, stream)
    said.write(SAID)
    said.flush()

    assert pipe.getvalue() == written


def test_a_process_without_a_console_says_nothing(monkeypatch):
    monkeypatch.setattr(sys, "stdout", None)  # as pythonw of Windows has it
    monkeypatch.setattr(sys, "stderr", None)

    speak_unicode()

    assert (sys.stdout, sys.stderr) == (None, None)
