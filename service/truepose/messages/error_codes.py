"""Codes of errors: short, never given twice, the same in every language and version.

What a code means stands in `errors.po` of each language: what happened, what it means for the data, what to
do now. An error without a code of its own has that of its nearest base; what is no exception has a name here.
"""

from dataclasses import dataclass
from typing import Final

from truepose.messages.catalogue import Catalogue

_DRIVERS: Final = "truepose_drivers"
_CODES: Final = {
    "InvalidRequest": "TP-1001",
    "UnknownParameter": "TP-1002",
    "UnreadableRequest": "TP-1003",
    "NoSuchPath": "TP-1004",
    "MethodNotPossible": "TP-1005",
    "TooLarge": "TP-1006",
    "TypeNotUnderstood": "TP-1007",
    "BodyLate": "TP-1008",
    "ForeignHost": "TP-1009",
    "ForeignPage": "TP-1010",
    "NotSignedIn": "TP-1011",
    "NotAllowedError": "TP-1012",
    "TooMany": "TP-1013",
    "SignInRefusedError": "TP-1014",
    "TooManyGuessesError": "TP-1015",
    "FreshSignInNeededError": "TP-1016",
    "UnknownPersonError": "TP-1017",
    "AccountRefusedError": "TP-1018",
    "NotFoundError": "TP-1020",
    "KeyReusedError": "TP-1021",
    "ConflictError": "TP-1022",
    "ConfigurationError": "TP-1023",
    "UnknownEffectError": "TP-1024",
    "UnknownRobotError": "TP-1025",
    "UnfitReadingError": "TP-1026",
    "NotNowError": "TP-2001",
    "WatchingTabletError": "TP-2002",
    "PersonMissingError": "TP-2003",
    "PersonUnreadableError": "TP-2004",
    "PersonUnknownError": "TP-2005",
    "ReasonMissingError": "TP-2006",
    "PlanRefusedError": "TP-2007",
    "MotionForbiddenError": "TP-2008",
    "ForeignRobotError": "TP-2009",
    "ForeignInstrumentError": "TP-2010",
    "ReadingRejectedError": "TP-2011",
    "AttentionNeededError": "TP-2012",
    "DeviceInUseError": "TP-2013",
    "MissingDeviceError": "TP-2014",
    "CellChangedError": "TP-2015",
    "NoBallbarError": "TP-2016",
    "FaultRefusedError": "TP-2017",
    "RealCellError": "TP-2018",
    "UnknownDeviceError": "TP-2019",
    "CertificateError": "TP-2020",
    "SomebodyElseActsError": "TP-2021",
    "WayNotClearError": "TP-2022",
    "driver ConnectFailedError": "TP-3001",
    "driver ConnectionLostError": "TP-3002",
    "driver NoReplyError": "TP-3003",
    "driver LinkError": "TP-3004",
    "driver RemoteProtocolError": "TP-3005",
    "driver ImplausibleReadingError": "TP-3006",
    "driver ConfigurationError": "TP-3007",
    "driver DriverFaultError": "TP-3008",
    "driver DeviceRefusedError": "TP-3009",
    "driver NotInitialisedError": "TP-3010",
    "driver BusyError": "TP-3011",
    "driver TargetRefusedError": "TP-3012",
    "driver MeasurementFailedError": "TP-3013",
    "driver BeamBrokenError": "TP-3014",
    "driver ReflectorNotFoundError": "TP-3015",
    "driver ArtefactNotSeenError": "TP-3016",
    "driver OutOfVolumeError": "TP-3017",
    "UnderdeterminedError": "TP-4001",
    "NothingMeasuredError": "TP-4002",
    "SessionsDifferError": "TP-4003",
    "RoleError": "TP-4004",
    "NeverDiagnosedError": "TP-4005",
    "RobotsMixedError": "TP-4006",
    "MissingFileError": "TP-4007",
    "UnreadableFileError": "TP-4008",
    "MissingEntryError": "TP-4009",
    "WrongUnitError": "TP-4010",
    "BadValueError": "TP-4011",
    "NewerVersionError": "TP-4012",
    "UnsafeArchiveError": "TP-4013",
    "InputFileError": "TP-4014",
    "UnwritableReportError": "TP-4015",
    "NoPdfError": "TP-4016",
    "InstalledCauseError": "TP-4017",
    "UnsuitableModelError": "TP-4018",
    "NotReadyError": "TP-4030",
    "WorkSpaceError": "TP-5001",
    "TooFewCandidatesError": "TP-5002",
    "AimError": "TP-5003",
    "NoWayError": "TP-5004",
    "BusyError": "TP-5005",
    "WorkerDiedError": "TP-5006",
    "TaskRefusedError": "TP-5007",
    "ClusterError": "TP-5008",
    "WorkersUnlikeError": "TP-5009",
    "PartFailedError": "TP-5010",
    "RecordRefusedError": "TP-6001",
    "DamagedDatabaseError": "TP-6002",
    "DatabaseAddressError": "TP-6003",
    "DatabaseInUseError": "TP-6004",
    "NewerSchemaError": "TP-6005",
    "ForeignDatabaseError": "TP-6006",
    "ChainHeadError": "TP-6007",
    "BackupError": "TP-6008",
    "DatabaseUsedError": "TP-6009",
    "ServerAwayError": "TP-6010",
    "ServerRefusedError": "TP-6011",
    "SimulationFailedError": "TP-7001",
    "ScenarioRefusedError": "TP-7002",
    "PortInUseError": "TP-7003",
    "UnusableHostError": "TP-7004",
    "MissingExtraError": "TP-7005",
    "NotReady": "TP-7006",
    "UnsafeStartError": "TP-7007",
    "MissingRightError": "TP-7008",
    "UnusableProxyError": "TP-7009",
    "DemoError": "TP-7010",
    "UnreadableRowError": "TP-8001",
    "TamperedRecordError": "TP-8002",
    "AnotherChainError": "TP-8003",
    "CellAnswerError": "TP-8004",
    "ProgramFailed": "TP-9001",
}
CODES: Final = tuple(_CODES.values())


@dataclass(frozen=True, slots=True)
class CodeExplanation:
    """What a code means, in words."""

    code: str
    happened: str
    data: str  # what it means for the data
    do: str


def code_of(error: BaseException) -> str:
    """Return the code of an error; of one that nobody foresaw, that of the program.

    What another process raised comes with its code.
    """
    carried = getattr(error, "code", None)
    if isinstance(carried, str) and carried in CODES:
        return carried
    names = (_name(kind) for kind in type(error).__mro__)
    return next((_CODES[name] for name in names if name in _CODES), _CODES["ProgramFailed"])


def code_named(name: str) -> str:
    """Return the code of what has a name in the table."""
    return _CODES[name]


def explain(code: str, words: Catalogue) -> CodeExplanation:
    """Return what a code means, in a language."""
    happened, data, do = (words.say(f"error.{code}.{part}") for part in ("happened", "data", "do"))
    return CodeExplanation(code, happened, data, do)


def _name(kind: type) -> str:
    of_driver = kind.__module__.partition(".")[0] == _DRIVERS
    return f"driver {kind.__name__}" if of_driver else kind.__name__
