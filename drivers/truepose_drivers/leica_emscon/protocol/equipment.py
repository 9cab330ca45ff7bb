"""States and kinds of equipment that an emScon server reports (SDK 3.6, enumerations of the C header)."""

from enum import IntEnum


class TrackerStatus(IntEnum):
    """Whether the tracker can take a measuring command."""

    NOT_READY = 0
    BUSY = 1
    READY = 2
    STATUS_INVALID_6D = 3


class TrackerProcessorStatus(IntEnum):
    """How far the tracker has started up; INITIALIZED can measure."""

    NO_TP_FOUND = 0
    TP_FOUND = 1
    NB_OPEN = 2
    BOOTED = 3
    COMPENSATION_SET = 4
    INITIALIZED = 5


class LaserProcessorStatus(IntEnum):
    """State of the laser tube."""

    LCP_COMM_FAILED = 0
    LCP_NOT_AVAIL = 1
    LASER_HEATING_UP = 2
    LASER_READY = 3
    UNABLE_TO_STABILIZE = 4
    LASER_OFF = 5


class ADMStatus(IntEnum):
    """State of the absolute distance meter."""

    NO_ADM = 0
    ADM_COMM_FAILED = 1
    ADM_READY = 2
    ADM_BUSY = 3
    HW_ERROR = 4
    SECURITY_LOCK_ACTIVE = 5
    NOT_COMPENSATED = 6


class NivelStatus(IntEnum):
    """Quality of a tilt reading."""

    ALL_OK = 0
    OUT_OF_RANGE_OK = 1
    OUT_OF_RANGE_NOK = 2
    NO_NIVEL = 3


class TrackerFace(IntEnum):
    """Which way round the head stands."""

    UNKNOWN = 0
    FACE_1 = 1
    FACE_2 = 2


class TriggerStatus(IntEnum):
    """State of the probe trigger."""

    TRIGGER_NOT_PRESSED = 0
    TRIGGER_PRESSED = 1


class MeasurementTipStatus(IntEnum):
    """State of the probe tip."""

    TIP_OK = 0
    UNKNOWN_TIP = 1
    MULTIPLE_TIPS_ATTACHED = 2


class TargetType(IntEnum):
    """Kind of reflector."""

    UNKNOWN = 0
    CORNER_CUBE = 1
    CATS_EYE = 2
    GLASS_PRISM = 3
    RFI_PRISM = 4
    RRR15 = 5
    RRR05 = 6
    BRR15 = 7
    BRR05 = 8
    TBR05 = 9


class LTSensorType(IntEnum):
    """Model of the tracker head."""

    UNDEFINED = 0
    SMART_OPTODYNE = 1
    SMART_LEICA = 2
    LT_D_500 = 3
    LT300 = 4
    LT301 = 5
    LT_D_800 = 6
    LT_D_700 = 7
    LT_D_600 = 8
    LT_D_640 = 9
    LT_D_706 = 10
    LT_D_709 = 11
    LT_D_840 = 12
    AT901_B = 13
    AT901_MR = 14
    AT901_LR = 15
    AT401 = 70
    NO_SENSOR = 99


class TrackerProcessorType(IntEnum):
    """Kind of tracker controller."""

    UNDEFINED = 0
    SMART310 = 1
    LT_CONTROLLER = 2
    EMBEDDED_CONTROLLER = 3
    EMBEDDED_CONTROLLER600 = 4
    ATC900 = 6
    ATC400 = 20


class TPMicroProcessorType(IntEnum):
    """Processor of the controller."""

    UNDEFINED = 0
    I486 = 1
    I686 = 2
    PXA250 = 20


class TrkAccuracyModel(IntEnum):
    """Model behind the a-priori accuracies."""

    UNKNOWN = 0
    MODEL_2005 = 1


class ADMType(IntEnum):
    """Kind of absolute distance meter."""

    UNKNOWN = 0
    LEICA_ADM = 1
    LEICA_AIFM = 2
    LEICA_ADM2 = 3


class ATRType(IntEnum):
    """Kind of target recognition camera."""

    NONE = 0
    ATR_4 = 1
    ATR_5I = 2


class NivelType(IntEnum):
    """Kind of tilt sensor."""

    UNKNOWN = 0
    NIVEL20 = 1
    NIVEL230 = 2
    NIVEL_AT4XX = 3


class MeteoStationType(IntEnum):
    """Kind of weather station."""

    NONE = 0
    THOMMEN = 1
    AT = 2


class WLANType(IntEnum):
    """Wireless adapter."""

    NONE = 0
    OWL211 = 1
    OWL221 = 2


class OverviewCameraType(IntEnum):
    """Kind of overview camera."""

    UNKNOWN = 0
    CLASSIC = 1
    TCAM_INTEGRATED = 2
    AT4XX_INTEGRATED = 20


class TriggerCardType(IntEnum):
    """Kind of trigger board."""

    NONE = 0
    SINGLE_TRACKER = 1


class ProbeType(IntEnum):
    """Kind of six-degree-of-freedom probe."""

    NONE = 0
    REFLECTOR = 1
    TPROBE = 2
    TSCAN = 3
    MACHINE_CONTROL_PROBE = 4
    MACHINE_CONTROL_PROBE_MULTI_SIDE = 5
    TCAM_TO_TRACKER_TOOL = 100
    ZOOM_ARTIFACT_TOOL = 200
