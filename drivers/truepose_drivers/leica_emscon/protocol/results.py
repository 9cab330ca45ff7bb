"""Members of the result packets 2..7 and 9..11 (SDK 3.6, C header); they start at byte 12 behind the status.

The packets of continuous measurements hold a block of elements behind their members.
"""

from collections.abc import Mapping

from truepose_drivers.leica_emscon.protocol.framing import PacketType
from truepose_drivers.leica_emscon.protocol.layouts import Layout

_AIR = "f64 temperature pressure humidity"
_STD = "f64 std1 std2 std3 std_total"
_APRIORI_STD = "f64 apriori_std1 apriori_std2 apriori_std3 apriori_std_total"
_APRIORI_COVARIANCE = "f64 apriori_covar12 apriori_covar13 apriori_covar23"
_QUATERNION_AND_ANGLES = (
    "f64 quaternion0 quaternion1 quaternion2 quaternion3 rotation_angle_x rotation_angle_y rotation_angle_z"
)
_POSITION_STD = (
    "f64 std_dev_position1 std_dev_position2 std_dev_position3 std_dev_position_total"
    " covar_position12 covar_position13 covar_position23"
)
_POSITION_APRIORI_STD = (
    "f64 apriori_std_dev_position1 apriori_std_dev_position2 apriori_std_dev_position3"
    " apriori_std_dev_position_total apriori_covar_position12 apriori_covar_position13"
    " apriori_covar_position23"
)
_ROTATION_STD = (
    "f64 std_dev_rotation_angle_x std_dev_rotation_angle_y std_dev_rotation_angle_z"
    " std_dev_rotation_angle_total covar_rotation_angle_xy covar_rotation_angle_xz"
    " covar_rotation_angle_yz"
)
_ROTATION_APRIORI_STD = (
    "f64 apriori_std_dev_rotation_angle_x apriori_std_dev_rotation_angle_y"
    " apriori_std_dev_rotation_angle_z apriori_std_dev_rotation_angle_total"
    " apriori_covar_rotation_angle_xy apriori_covar_rotation_angle_xz apriori_covar_rotation_angle_yz"
)
_POSITION = "f64 position1 position2 position3"
_MODE = "MeasMode meas_mode; bool is_try_mode"
_COUNT = "i32 number_of_results"
_TIP = "MeasurementTipStatus tip_status; i32 internal_tip_adapter_id tip_adapter_interface"
_STAMP = "i32 time1 time2"  # seconds, then microseconds since the start of the measurement


def _layout(*groups: str) -> Layout:
    return Layout.of("; ".join(groups))


RESULTS: Mapping[int, Layout] = {
    PacketType.SINGLE_MEAS_RESULT: _layout(
        _MODE,
        "f64 val1 val2 val3",
        _STD,
        "f64 pointing_error1 pointing_error2 pointing_error3",
        _APRIORI_STD,
        _AIR,
    ),
    PacketType.SINGLE_MEAS_RESULT_2: _layout(
        _MODE,
        "f64 val1 val2 val3",
        _STD,
        "f64 covar12 covar13 covar23",
        "f64 pointing_error_h pointing_error_v pointing_error_d",
        _APRIORI_STD,
        _APRIORI_COVARIANCE,
        _AIR,
    ),
    PacketType.MULTI_MEAS_RESULT: _layout(_COUNT, _MODE, _AIR),
    PacketType.MULTI_MEAS_RESULT_2: _layout(_COUNT, _MODE, _AIR),
    PacketType.STATIONARY_PROBE_MEAS_RESULT: _layout(
        _MODE,
        "TriggerStatus trigger_status; i32 rotation_status internal_probe_id field_number",
        _TIP,
        _POSITION,
        _POSITION_STD,
        _POSITION_APRIORI_STD,
        _QUATERNION_AND_ANGLES,
        _ROTATION_STD,
        _ROTATION_APRIORI_STD,
        _AIR,
    ),
    PacketType.CONTINUOUS_PROBE_MEAS_RESULT: _layout(
        _COUNT, _MODE, "i32 internal_probe_id field_number", _TIP, _AIR
    ),
    PacketType.NIVEL_RESULT: _layout("NivelStatus nivel_status; f64 x_tilt y_tilt nivel_temperature"),
    PacketType.REFLECTOR_POS_RESULT: _layout("f64 val1 val2 val3"),
    PacketType.PROBE_POS_RESULT: _layout("i32 rotation_status", _TIP, _POSITION, _QUATERNION_AND_ANGLES),
}
"""Members that every packet of the type has, elements not included."""

ELEMENTS: Mapping[int, Layout] = {
    PacketType.MULTI_MEAS_RESULT: _layout("MeasurementStatus status", _STAMP, "f64 val1 val2 val3"),
    PacketType.MULTI_MEAS_RESULT_2: _layout(
        "MeasurementStatus status", _STAMP, "f64 val1 val2 val3", _APRIORI_STD, _APRIORI_COVARIANCE
    ),
    PacketType.CONTINUOUS_PROBE_MEAS_RESULT: _layout(
        "MeasurementStatus status; TriggerStatus trigger_status; i32 rotation_status",
        _STAMP,
        _POSITION,
        _POSITION_STD,
        _QUATERNION_AND_ANGLES,
        _ROTATION_STD,
    ),
}
"""One element of the packet types that carry blocks; member number_of_results counts them."""
