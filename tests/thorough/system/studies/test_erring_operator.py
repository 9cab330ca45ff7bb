"""The study of operators who err: a tiny run, so that it does not rot; its figures are in docs."""

import json

import pytest

from tests.integration.web.ballbar_bench import PLACE
from tests.studies.hardening.erring_operator.__main__ import main

pytestmark = pytest.mark.usefixtures("forked_processes")

ROBOT = ("lrmate-tilted", 3, {"poses": 6, "placements": [PLACE]})


def test_nothing_moves_that_must_not_in_a_random_session(tmp_path, capsys):
    asked = ["--sessions", "1", "--robots", "1", "--deeds", "8", "--processes", "1", "--seed", "5"]

    status = main([*asked, "--out", str(tmp_path)], [ROBOT])

    found = json.loads((tmp_path / "erring_operator.json").read_text())
    assert found["sessions"] == 1
    assert found["motions_attached"] == 0
    assert found["seen"]["faults"] == found["lost"] == found["broken"] == []
    assert status == 0 or found["seen"]["motions"] == 0  # so few deeds need not move the arm
    assert json.loads(capsys.readouterr().out) == found
