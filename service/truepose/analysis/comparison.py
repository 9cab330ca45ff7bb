"""What has changed on one robot: its stored diagnoses, one for each measurement, compared over time."""

from collections.abc import Iterable, Sequence

from truepose.analysis.errors import NeverDiagnosedError, RobotsMixedError
from truepose.diagnosis.history import CauseOverTime, DatedDiagnosis, compare, place_in_time
from truepose.messages.message import message
from truepose.storage.records import DiagnosisRecord


def compare_over_time(
    robot: str, records: Sequence[DiagnosisRecord]
) -> tuple[list[DiagnosisRecord], tuple[CauseOverTime, ...]]:
    """Return the records that were compared, in the order of their readings, and the causes in them.

    Records that do not say when their readings were taken stand last, and nothing is subtracted from them.

    Of several diagnoses of the same readings the latest counts: they share their noise, so nothing can
    be learnt from their difference.

    Raises
    ------
    NeverDiagnosedError
        There is no record.
    RobotsMixedError
        The records are of robots with different serial numbers.
    """
    if not records:
        raise NeverDiagnosedError(message("refused.never_diagnosed", robot=repr(robot)))
    _check_one_robot(robot, records)
    # By when their readings were taken, not by when somebody had them diagnosed.
    counting = sorted(_latest(records), key=lambda record: place_in_time(record.measured_at, record.id))
    return counting, compare(dated_diagnoses(counting))


def dated_diagnoses(records: Iterable[DiagnosisRecord]) -> list[DatedDiagnosis]:
    """Return diagnoses as far as a comparison needs them."""
    return [DatedDiagnosis(record.id, record.measured_at, record.diagnosis) for record in records]


def _check_one_robot(robot: str, records: Sequence[DiagnosisRecord]) -> None:
    serials = {record.robot_serial_number for record in records} - {""}
    if len(serials) > 1:
        raise RobotsMixedError(
            message("refused.robots_mixed", robot=repr(robot), serials=", ".join(sorted(serials)))
        )


def _latest(records: Sequence[DiagnosisRecord]) -> Iterable[DiagnosisRecord]:
    by_readings: dict[tuple[str, int], DiagnosisRecord] = {}
    for record in sorted(records, key=lambda record: record.id):
        by_readings[_readings_of(record)] = record
    return by_readings.values()


def _readings_of(record: DiagnosisRecord) -> tuple[str, int]:
    if record.session_id is not None:
        return "session", record.session_id  # a running one may have been made a campaign several times
    return "campaign", record.campaign_id
