"""The service in figures, as Prometheus reads them (text format 0.0.4).

What happens is counted as it does; what stands in the database or in memory is looked up when somebody asks.
"""

from collections.abc import Iterable, Mapping
from typing import Final

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.core import GaugeMetricFamily, Metric, SummaryMetricFamily
from prometheus_client.registry import Collector

from truepose.health import State

MEDIA_TYPE: Final = "text/plain; version=0.0.4; charset=utf-8"
_REQUEST_S: Final = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0)
_COMMIT_S: Final = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 5.0)


class Metrics:
    """All figures of one application."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        self._requests = Counter(
            "truepose_requests",
            "Number of requests answered.",
            ["operation", "status"],
            registry=self._registry,
        )
        self._latency = Histogram(
            "truepose_request_seconds",
            "Time until the response headers are sent.",
            ["operation"],
            buckets=_REQUEST_S,
            registry=self._registry,
        )
        self._streams = Gauge(
            "truepose_event_streams", "Number of open event streams.", registry=self._registry
        )
        self._commits = Histogram(
            "truepose_commit_seconds",
            "Time until a transaction is on disk.",
            buckets=_COMMIT_S,
            registry=self._registry,
        )

    def answered(self, operation: str, status: int, seconds: float) -> None:
        """Count the head of an answer and how long it took."""
        self._requests.labels(operation, str(status)).inc()
        self._latency.labels(operation).observe(seconds)

    def streaming(self, change: int) -> None:
        """Count event streams that are open."""
        self._streams.inc(change)

    def committed(self, seconds: float) -> None:
        """Count a transaction that is on the disk."""
        self._commits.observe(seconds)

    def text(self, state: State, program: dict[str, str]) -> bytes:
        """Return everything that was counted, the state as it is now, and which program it is of."""
        now = CollectorRegistry()
        now.register(_StateCollector(state, program))
        return generate_latest(self._registry) + generate_latest(now)


class _StateCollector(Collector):
    """The state in the library's terms."""

    def __init__(self, state: State, program: dict[str, str]) -> None:
        self._state = state
        self._program = program

    def collect(self) -> Iterable[Metric]:
        state, records = self._state, self._state.records
        linked = {name: int(link.connected) for name, link in state.devices.items()}
        yield _one("info", "Version of the software and schema of its database.", 1, **self._program)
        yield _several("sessions", "Number of sessions by state.", "state", state.sessions)
        yield _several("jobs", "Number of jobs by state.", "state", state.jobs)
        yield _durations(state)
        yield _one("readings_stored", "Number of readings in the database.", records.readings)
        yield _several("device_connected", "1 if the device is connected.", "device", linked)
        yield _one("disk_free_bytes", "Free space on the disk of the database.", records.free_bytes)
        yield _one("database_bytes", "Size of the database and its log.", records.size_bytes)
        yield _one("memory_bytes", "Memory used by the process.", state.memory_bytes)
        yield _one("records_refused", "1 if the disk refuses records.", bool(records.refused))
        yield _one("chain_links", "Number of entries in the hash chain.", records.links)
        yield _one("chain_damaged", "1 if a record was altered.", bool(records.damage))
        if state.copies is not None and state.copies.age_s is not None:
            yield _one("backup_age_seconds", "Age of the latest backup.", state.copies.age_s)
        yield _several(
            "certificate_days_left", "Days until the certificate expires.", "artefact", state.certificates
        )
        yield _one("log_lines_lost", "Log lines that could not be written since the start.", state.lines_lost)


def _durations(state: State) -> Metric:
    family = SummaryMetricFamily("truepose_job_seconds", "Run time of jobs that have ended.", labels=["kind"])
    for kind, (count, seconds) in state.job_seconds.items():
        family.add_metric([kind], count_value=count, sum_value=seconds)
    return family


def _one(name: str, meaning: str, value: float, **labels: str) -> Metric:
    family = GaugeMetricFamily(f"truepose_{name}", meaning, labels=list(labels))
    family.add_metric(list(labels.values()), value)
    return family


def _several(name: str, meaning: str, label: str, values: Mapping[str, int]) -> Metric:
    family = GaugeMetricFamily(f"truepose_{name}", meaning, labels=[label])
    for key, value in values.items():
        family.add_metric([key], value)
    return family
