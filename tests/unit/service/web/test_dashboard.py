"""The Grafana dashboard asks for nothing that the service does not say."""

import json
import re
from importlib.resources import files

import pytest

from truepose.health import Copies, DeviceLink, State
from truepose.web.middleware.metrics import Metrics

EVERYTHING = State(
    sessions={"running": 1},
    jobs={"queued": 2},
    job_seconds={"identification": (3, 4.5)},
    devices={"robot": DeviceLink(True)},
    certificates={"tool": 30},
    copies=Copies(86400.0, 60.0),
)


@pytest.fixture(scope="module")
def text():
    metrics = Metrics()
    metrics.answered("get_cell", 200, 0.01)
    metrics.committed(0.003)
    return metrics.text(EVERYTHING, {"version": "1.2.3", "schema": "0012"}).decode()


@pytest.fixture(scope="module")
def dashboard():
    return json.loads(files("truepose").joinpath("app", "deployment", "dashboard.json").read_text())


def queries(dashboard):
    return [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]


def said(text):
    """Return the labels of each metric."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return {re.match(r"\w+", line)[0]: set(re.findall(r'(\w+)="', line)) for line in lines}


def test_every_query_names_figures_and_labels_that_there_are(text, dashboard):
    there = said(text)

    for query in queries(dashboard):
        asked = re.findall(r"(truepose_\w+)\{([^}]*)\}", query)
        assert asked, query
        for name, labels in asked:
            assert name in there, query
            assert set(re.findall(r"(\w+)=", labels)) - {"instance"} <= there[name], query


def test_every_legend_names_a_label_of_its_query(text, dashboard):
    there = said(text)

    for panel in dashboard["panels"]:
        for target in panel["targets"]:
            names = set(re.findall(r"\{\{(\w+)\}\}", target["legendFormat"])) - {"instance"}
            found = set().union(*(there[name] for name in re.findall(r"(truepose_\w+)\{", target["expr"])))
            assert names <= found, target


def test_what_the_dashboard_shows_covers_every_figure(text, dashboard):
    asked = " ".join(queries(dashboard)) + json.dumps(dashboard["templating"])
    families = {re.split(r" ", line)[2] for line in text.splitlines() if line.startswith("# TYPE")}

    unseen = {name for name in families if name not in asked and not name.endswith("_created")}
    assert unseen == set()


def test_the_figures_are_those_of_the_state(text):
    assert 'truepose_sessions{state="running"} 1.0' in text
    assert 'truepose_job_seconds_sum{kind="identification"} 4.5' in text
    assert 'truepose_device_connected{device="robot"} 1.0' in text
    assert "truepose_backup_age_seconds 60.0" in text
    assert 'truepose_certificate_days_left{artefact="tool"} 30.0' in text


def test_without_a_schedule_no_copy_has_an_age():
    assert "backup_age" not in Metrics().text(State(), {}).decode()
