"""The study of ballbars whose signals come and go: a small part of it; its figures are in docs."""

import json

from tests.studies.lost_signals.__main__ import main

SESSIONS = 12


def test_the_arm_never_moves_with_the_ballbar_attached_whatever_signal_is_lost(capsys):
    status = main(["--sessions", str(SESSIONS), "--seed", "1000", "--processes", "1"])

    found = json.loads(capsys.readouterr().out)
    assert found["motions_attached"] == 0
    assert status == 0
    assert found["motions"] > SESSIONS
    assert found["confirmed_attached"] == found["refused"] > SESSIONS
    assert len(found["troubles"]) == 7
