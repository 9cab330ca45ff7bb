"""Units, modes and parameters that an emScon client sets (SDK 3.6, enumerations of the C header)."""

from enum import IntEnum


class LengthUnit(IntEnum):
    """Unit of lengths and coordinates on the wire."""

    METER = 0
    MILLIMETER = 1
    MICRON = 2
    FOOT = 3
    YARD = 4
    INCH = 5


class AngleUnit(IntEnum):
    """Unit of angles on the wire."""

    RADIAN = 0
    DEGREE = 1
    GON = 2


class TemperatureUnit(IntEnum):
    """Unit of temperatures on the wire."""

    CELSIUS = 0
    FAHRENHEIT = 1


class PressureUnit(IntEnum):
    """Unit of air pressure on the wire."""

    MBAR = 0
    HECTOPASCAL = 1
    KILOPASCAL = 2
    MM_HG = 3
    PSI = 4
    IN_H2O = 5
    IN_HG = 6


class HumidityUnit(IntEnum):
    """Unit of humidity on the wire [%]."""

    RELATIVE = 0


class CoordinateSystemType(IntEnum):
    """Meaning of the three coordinates: right- or left-handed, cylindrical, spherical."""

    RHR = 0
    LHRX = 1
    LHRY = 2
    LHRZ = 3
    CCW = 4
    CCC = 5
    SCW = 6
    SCC = 7


class MeasMode(IntEnum):
    """What StartMeasurement does; AT40x trackers know STATIONARY alone."""

    STATIONARY = 0
    CONTINUOUS_TIME = 1
    CONTINUOUS_DISTANCE = 2
    GRID = 3
    SPHERE_CENTER = 4
    CIRCLE_CENTER = 5
    STATIONARY_6D = 6
    CONTINUOUS_TIME_6D = 7
    CONTINUOUS_DISTANCE_6D = 8
    GRID_6D = 9
    SPHERE_CENTER_6D = 10
    CIRCLE_CENTER_6D = 11


class StatisticMode(IntEnum):
    """STANDARD answers with SingleMeasResult, EXTENDED with SingleMeasResult2."""

    STANDARD = 0
    EXTENDED = 1


class RegionType(IntEnum):
    """Shape that bounds a continuous measurement."""

    SPHERE = 0
    BOX = 1


class WeatherMonitorStatus(IntEnum):
    """What the server does with the weather station."""

    NOT_CONNECTED = 0
    READ_ONLY = 1
    READ_AND_CALCULATE_REFRACTIONS = 2


class SystemParameter(IntEnum):
    """Parameters of Get/SetLongSystemParameter; those named D_ belong to the double commands."""

    KEEP_LAST_POSITION_FLAG = 0
    WEATHER_MONITOR_SETTING = 1
    SHOW_ALL_6D_MEASUREMENTS = 2
    LASER_POINTER_CAPTURE_BEAM = 3
    DISPLAY_REFLECTOR_POSITION = 10
    PROBE_CONFIG_BUTTON = 50
    PROBE_CONFIG_BUTTON_EVENT = 51
    PROBE_CONFIG_TIP = 52
    PROBE_CONFIG_SOUND_VOLUME = 53
    PROBE_CONFIG_POWER_OFF_TIME = 54
    QUICK_RELEASE_STATUS = 60
    TCP_COMMAND_QUEUE_SIZE = 200
    SYSTEM_MAX_6D_DATA_RATE = 300
    TCP_DATA_PACKET_RATE = 400
    POWER_LOCK_FUNCTION_AVAILABLE = 410
    POWER_LOCK_FUNCTION_ACTIVE = 411
    POWER_LOCK_MODE = 450
    D_TEMPERATURE_THRESHOLD = 1000
    D_PRESSURE_THRESHOLD = 1001
    D_HUMIDITY_THRESHOLD = 1002
    D_SYSTEM_LONGEST_3D_DISTANCE_IFM = 1100
    D_SYSTEM_LONGEST_3D_DISTANCE_ADM = 1101
    D_SYSTEM_LONGEST_6D_DISTANCE = 1102
    AT4XX_CONTROLLER_BATTERY_STATUS = 5000
    AT4XX_SENSOR_BATTERY_STATUS = 5001
    AT4XX_INCLINATION_SENSOR_STATE = 5002
