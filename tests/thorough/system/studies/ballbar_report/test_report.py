"""The command that writes the report."""

import json

import pytest

from tests.studies.ballbar_report.__main__ import main


def test_the_report_stands_as_a_page_and_as_a_document(tmp_path, capsys):
    status = main(["--sections", "pose-device", "--draws", "4000", "--jobs", "1", "--out", str(tmp_path)])

    assert status == 0
    document = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert [section["title"] for section in document["sections"]] == ["The pose device"]
    assert document["extent"]["draws"] == 4000
    assert "T3, drawn" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "The pose device" in capsys.readouterr().out


@pytest.mark.parametrize("wrong", [["--robots", "0"], ["--sections", "robots,tables"]])
def test_what_cannot_be_measured_is_refused(wrong, tmp_path, capsys):
    with pytest.raises(SystemExit):
        main([*wrong, "--out", str(tmp_path)])

    assert "argument" in capsys.readouterr().err
