"""Members of every request and answer (SDK 3.6, C header); commands not listed carry none.

A request's members start at byte 12, an answer's at byte 16 behind the result status.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from truepose_drivers.leica_emscon.protocol.commands import Command
from truepose_drivers.leica_emscon.protocol.packet_layouts import Layout


@dataclass(frozen=True, slots=True)
class Exchange:
    """What goes out with a command and what comes back with its answer."""

    request: Layout
    answer: Layout

    @classmethod
    def of(cls, request: str, answer: str) -> Self:
        """Compile both layouts."""
        return cls(Layout.of(request), Layout.of(answer))


# By name: the request of SET_<name> and the answer of GET_<name>.
_SET_AND_TOLD: Mapping[str, str] = {
    "TEMPERATURE_RANGE": "i32 temperature_range",
    "UNITS": (
        "LengthUnit len_unit_type; AngleUnit ang_unit_type; TemperatureUnit temp_unit_type; "
        "PressureUnit press_unit_type; HumidityUnit hum_unit_type"
    ),
    "STATION_ORIENTATION_PARAMS": "f64 val1 val2 val3 rot1 rot2 rot3",
    "TRANSFORMATION_PARAMS": "f64 val1 val2 val3 rot1 rot2 rot3 scale",
    "BOX_REGION_PARAMS": "f64 p1_val1 p1_val2 p1_val3 p2_val1 p2_val2 p2_val3",
    "SPHERE_REGION_PARAMS": "f64 val1 val2 val3 radius",
    "ENVIRONMENT_PARAMS": "f64 temperature pressure humidity",
    "REFRACTION_PARAMS": "f64 ifm_refraction_index adm_refraction_index",
    "MEASUREMENT_MODE": "MeasMode meas_mode",
    "COORDINATE_SYSTEM_TYPE": "CoordinateSystemType coord_sys_type",
    "STATIONARY_MODE_PARAMS": "i32 meas_time; bool use_adm",
    "CONTINUOUS_TIME_MODE_PARAMS": (
        "i32 time_separation number_of_points; bool use_region; RegionType region_type"
    ),
    "CONTINUOUS_DISTANCE_MODE_PARAMS": (
        "f64 spatial_distance; i32 number_of_points; bool use_region; RegionType region_type"
    ),
    "SPHERE_CENTER_MODE_PARAMS": "f64 spatial_distance; i32 number_of_points; bool fix_radius; f64 radius",
    "CIRCLE_CENTER_MODE_PARAMS": "f64 spatial_distance; i32 number_of_points; bool fix_radius; f64 radius",
    "GRID_MODE_PARAMS": "f64 val1 val2 val3; i32 number_of_points; bool use_region; RegionType region_type",
    "REFLECTOR": "i32 internal_reflector_id",
    "SEARCH_PARAMS": "f64 search_radius; i32 time_out",
    "ADM_PARAMS": "f64 target_stability_tolerance; i32 retry_time_frame number_of_retrys",
    "SYSTEM_SETTINGS": (
        "WeatherMonitorStatus weather_monitor_status; bool apply_transformation_params "
        "apply_station_orientation_params keep_last_position send_unsolicited_messages "
        "send_reflector_position_data try_measurement_mode has_nivel has_video_camera"
    ),
    "TRANSFORMATION_INPUT_PARAMS": (
        "i32 result_type; f64 trans_val1 trans_val2 trans_val3 rot_val1 rot_val2 rot_val3 "
        "scale trans_std_val1 trans_std_val2 trans_std_val3 rot_std_val1 rot_std_val2 rot_std_val3 "
        "scale_std"
    ),
    "COMPENSATION": "i32 internal_compensation_id",
    "STATISTIC_MODE": "StatisticMode stationary_measurements; StatisticMode continuous_measurements",
    "CAMERA_PARAMS": "i32 contrast brightness saturation",
    "LASER_ON_TIMER": "i32 laser_on_time_offset_hour laser_on_time_offset_minute",
    "TRIGGER_SOURCE": "i32 trigger_source",
    "MEASUREMENT_CAMERA_MODE": "i32 camera_mode",
    "T_CAM_TO_TRACKER_COMPENSATION": "i32 internal_t_cam_to_tracker_compensation_id",
    "PROBE_COMPENSATION": "i32 internal_probe_compensation_id",
    "EXTERN_TRIGGER_PARAMS": "i32 clock_transition trigger_mode start_signal minimal_time_delay",
}
_REQUESTS: dict[Command, str] = {
    Command.SWITCH_LASER: "bool is_on",
    Command.GO_POSITION: "f64 val1 val2 val3; bool use_adm",
    Command.GO_POSITION_HVD: "f64 hz_angle vt_angle distance; bool use_adm",
    Command.POSITION_RELATIVE_HV: "f64 hz_val vt_val",
    Command.POINT_LASER: "f64 val1 val2 val3",
    Command.POINT_LASER_HVD: "f64 hz_angle vt_angle distance",
    Command.MOVE_HV: "i32 hz_speed vt_speed",
    Command.GO_NIVEL_POSITION: "i32 nivel_position",
    Command.FIND_REFLECTOR: "f64 aprox_distance",
    Command.LOOK_FOR_TARGET: "f64 val1 val2 val3 search_radius",
    Command.ADD_TRANSFORMATION_NOMINAL_POINT: "f64 val1 val2 val3 std1 std2 std3 covar12 covar13 covar23",
    Command.ADD_TRANSFORMATION_ACTUAL_POINT: "f64 val1 val2 val3 std1 std2 std3 covar12 covar13 covar23",
    Command.ADD_DRIVE_POINT: "i32 internal_reflector_id; f64 val1 val2 val3",
    Command.GET_STILL_IMAGE: "i32 image_file_type",
    Command.CONVERT_DISPLAY_COORDINATES: "i32 conversion_type; f64 val1 val2 val3",
    Command.GO_BIRD_BATH2: "bool clock_wise",
    Command.GET_ERROR_ELLIPSOID: (
        "f64 coord1 coord2 coord3 std_dev1 std_dev2 std_dev3 covar12 covar13 covar23"
    ),
    Command.SET_LONG_SYSTEM_PARAMETER: "SystemParameter system_param; i32 parameter",
    Command.GET_LONG_SYSTEM_PARAMETER: "SystemParameter system_param",
    Command.SET_DOUBLE_SYSTEM_PARAMETER: "SystemParameter system_param; f64 parameter",
    Command.GET_DOUBLE_SYSTEM_PARAMETER: "SystemParameter system_param",
    Command.CLEAR_COMMAND_QUEUE: "i32 clear_queue_type",
    Command.GO_AND_MEASURE: "f64 val1 val2 val3",
    Command.SET_TIP_ADAPTER: "i32 internal_tip_adapter_id",
}
_ANSWERS: dict[Command, str] = {
    Command.GET_SYSTEM_STATUS: (
        "ResultStatus last_result_status; TrackerProcessorStatus tracker_processor_status; "
        "LaserProcessorStatus laser_status; ADMStatus adm_status; i32 major_version_number "
        "minor_version_number build_number; WeatherMonitorStatus weather_monitor_status; i32 "
        "flags_value tracker_serial_number"
    ),
    Command.GET_TRACKER_STATUS: "TrackerStatus tracker_status",
    Command.GET_REFLECTORS: (
        "i32 total_reflectors internal_reflector_id; TargetType target_type; f64 surface_offset; "
        "text32 reflector_name"
    ),
    Command.LOOK_FOR_TARGET: "f64 hz_angle vt_angle",
    Command.GET_DIRECTION: "f64 hz_angle vt_angle",
    Command.CALL_ORIENT_TO_GRAVITY: "f64 omega phi",
    Command.CALL_TRANSFORMATION: (
        "f64 trans_val1 trans_val2 trans_val3 rot_val1 rot_val2 rot_val3 scale trans_std_val1 "
        "trans_std_val2 trans_std_val3 rot_std_val1 rot_std_val2 rot_std_val3 scale_std rms max_dev "
        "variance_factor"
    ),
    Command.GET_TRANSFORMED_POINTS: (
        "i32 total_points; f64 val1 val2 val3 std1 std2 std3 std_total covar12 covar13 covar23 "
        "residual_val1 residual_val2 residual_val3"
    ),
    Command.CALL_INTERMEDIATE_COMPENSATION: "f64 total_rms max_dev; i32 warning_flags",
    Command.GET_STILL_IMAGE: "i32 image_filetype file_size; u8 file_start",
    Command.GET_COMPENSATIONS: (
        "i32 total_compensations internal_compensation_id; text32 tracker_compensation_name; text128 "
        "tracker_compensation_comment; text32 adm_compensation_name; bool "
        "has_measurement_camera_mounted"
    ),
    Command.CHECK_BIRD_BATH: (
        "f64 initial_hz_angle initial_vt_angle initial_distance hz_angle_diff vt_angle_diff distance_diff"
    ),
    Command.GET_TRACKER_DIAGNOSTICS: (
        "f64 trk_photo_sensor_x_val trk_photo_sensor_y_val trk_photo_sensor_i_val "
        "ref_photo_sensor_x_val ref_photo_sensor_y_val ref_photo_sensor_i_val ad_converter_range "
        "servo_control_point_x servo_control_point_y laser_light_ratio; i32 laser_control_mode; f64 "
        "sensor_inside_temperature; i32 lcp_run_time laser_tube_run_time"
    ),
    Command.GET_ADM_INFO: "i32 firmware_major_version_number firmware_minor_version_number serial_number",
    Command.GET_TP_INFO: (
        "i32 tp_boot_major_version_number tp_boot_minor_version_number "
        "tp_firmware_major_version_number tp_firmware_minor_version_number "
        "lcp_firmware_major_version_number lcp_firmware_minor_version_number; TrackerProcessorType "
        "trackerprocessor_type; TPMicroProcessorType micro_processor_type; i32 "
        "micro_processor_clock_speed; LTSensorType laser_tracker_sensor_type"
    ),
    Command.GET_NIVEL_INFO: "i32 firmware_major_version_number firmware_minor_version_number serial_number",
    Command.CONVERT_DISPLAY_COORDINATES: "f64 val1 val2 val3",
    Command.GET_FACE: "TrackerFace tracker_face",
    Command.GET_CAMERAS: (
        "i32 total_cameras internal_camera_id serial_number camera_type; text32 name; text128 comment"
    ),
    Command.GET_CAMERA: "i32 internal_camera_id; bool measurement_camera_is_mounted",
    Command.GET_PROBES: (
        "i32 total_probes internal_probe_id serial_number; ProbeType probe_type; i32 "
        "number_of_fields; text32 name; text128 comment"
    ),
    Command.GET_PROBE: "i32 internal_probe_id",
    Command.GET_TIP_ADAPTERS: (
        "i32 total_tip_adapters internal_tip_adapter_id assembly_id serial_number_low_part "
        "serial_number_high_part tip_type; f64 radius length; text32 name; text128 comment"
    ),
    Command.GET_TIP_ADAPTER: "i32 internal_tip_adapter_id tip_adapter_interface",
    Command.GET_T_CAM_TO_TRACKER_COMPENSATIONS: (
        "i32 total_compensations internal_t_cam_to_tracker_compensation_id "
        "internal_tracker_compensation_id internal_camera_id; bool is_active; i32 "
        "tracker_serial_number; text32 t_cam_to_tracker_compensation_name; text128 "
        "t_cam_to_tracker_compensation_comment"
    ),
    Command.GET_PROBE_COMPENSATIONS: (
        "i32 total_compensations internal_probe_compensation_id internal_probe_id field_number; bool "
        "is_active marked_for_export preliminary; text32 probe_compensation_name; text128 "
        "probe_compensation_comment"
    ),
    Command.GET_TIP_TO_PROBE_COMPENSATIONS: (
        "i32 total_compensations internal_tip_to_probe_compensation_id internal_tip_adapter_id "
        "tip_adapter_interface internal_probe_compensation_id; bool marked_for_export; text32 "
        "tip_to_probe_compensation_name; text128 tip_to_probe_compensation_comment"
    ),
    Command.GET_TIP_TO_PROBE_COMPENSATION: "i32 internal_tip_to_probe_compensation_id",
    Command.GET_ERROR_ELLIPSOID: (
        "f64 std_dev_x std_dev_y std_dev_z rotation_angle_x rotation_angle_y rotation_angle_z"
    ),
    Command.GET_MEASUREMENT_CAMERA_INFO: (
        "i32 firmware_major_version_number firmware_minor_version_number serial_number "
        "camera_type; text32 name; i32 compensation_id_number "
        "zoom_serial_number zoom_adjustment_id_number zoom2_d_compensation_id_number "
        "zoom_proj_center_comp_id_number; f64 max_distance min_distance; i32 nr_of_pixels_x "
        "nr_of_pixels_y; f64 pixel_size_x pixel_size_y; i32 max_data_rate"
    ),
    Command.GET_MEASUREMENT_PROBE_INFO: (
        "i32 firmware_major_version_number firmware_minor_version_number serial_number; ProbeType "
        "probe_type; i32 compensation_id_number active_field connection_type "
        "number_of_tip_adapters probe_button_type number_of_fields; bool "
        "has_wide_angle_receiver; i32 number_of_tip_data_sets number_of_melodies "
        "number_of_loudnes_steps"
    ),
    Command.GET_LONG_SYSTEM_PARAMETER: "SystemParameter system_param; i32 parameter",
    Command.GET_MEASUREMENT_STATUS_INFO: "ResultStatus last_result_status; i32 measurement_status_info",
    Command.GET_COMPENSATIONS2: (
        "i32 total_compensations internal_compensation_id; text32 tracker_compensation_name; text128 "
        "tracker_compensation_comment; text32 adm_compensation_name; text128 "
        "adm_compensation_comment; bool has_measurement_camera_mounted is_active"
    ),
    Command.GET_CURRENT_PRISM_POSITION: "f64 val1 val2 val3",
    Command.GET_DOUBLE_SYSTEM_PARAMETER: "SystemParameter system_param; f64 parameter",
    Command.GET_OBJECT_TEMPERATURE: "f64 object_temperature",
    Command.GET_TRIGGER_BOARD_INFO: (
        "TriggerCardType trigger_card_type; i32 fpga_version max_trigger_frequency error_code"
    ),
    Command.GET_OVERVIEW_CAMERA_INFO: (
        "OverviewCameraType camera_type; text32 camera_name; bool is_color_camera; f64 focal_length "
        "horizontal_chip_size vertical_chip_size; bool mirror_image_hz mirror_image_vt"
    ),
    Command.GET_ADM_INFO2: (
        "ADMType adm_type; text32 adm_name; i32 serial_number firmware_major_version_number "
        "firmware_minor_version_number; f64 max_distance min_distance; i32 max_data_rate; f64 "
        "accuracy_adm_distance"
    ),
    Command.GET_TRACKER_INFO: (
        "LTSensorType tracker_type; text32 tracker_name; i32 serial_number compensation_id_number; "
        "bool has_adm has_overview_camera has_nivel; f64 nivel_mount_offset max_distance "
        "min_distance; i32 max_data_rate number_of_faces; f64 hz_angle_range vt_angle_range; "
        "TrkAccuracyModel accuracy_model; i32 maj_lcp_firmware_version min_lcp_firmware_version"
    ),
    Command.GET_NIVEL_INFO2: (
        "NivelType nivel_type; text32 nivel_name; i32 serial_number firmware_major_version_number "
        "firmware_minor_version_number; f64 measurement_range measurement_accuracy_offset "
        "measurement_accuracy_factor"
    ),
    Command.GET_TIP_TO_PROBE_COMPENSATIONS2: (
        "i32 total_compensations internal_tip_to_probe_compensation_id internal_tip_adapter_id "
        "tip_adapter_interface internal_probe_compensation_id; bool marked_for_export; "
        "i32 compensation_type; text32 tip_to_probe_compensation_name; text128 "
        "tip_to_probe_compensation_comment; text32 shank_compensation_name"
    ),
    Command.GET_ATR_INFO: (
        "ATRType atr_type; text32 atr_name; i32 maj_firmware_version min_firmware_version "
        "build_firmware_version hardware_version errorcode fpga_version; f64 max_distance "
        "min_distance field_of_view max_tracking_speed"
    ),
    Command.GET_METEO_STATION_INFO: (
        "MeteoStationType meteo_station_type; text32 identifier; i32 firmware_major_version_number "
        "firmware_minor_version_number"
    ),
    Command.GET_AT4XX_INFO: (
        "LTSensorType tracker_type; text32 tracker_name; i32 serial_number major_firmware_version "
        "minor_firmware_version processor_board_fw_build_number sensor_board_fw_build_number "
        "major_os_version minor_os_version major_server_software_version "
        "minor_server_software_version server_software_build_number; WLANType wlan_type; "
        "TPMicroProcessorType xscale_type; i32 min_measure_time; f64 min_distance max_distance "
        "std_dev_dist_offset_adm std_dev_angle_const std_dev_angle_offset std_dev_angle_factor"
    ),
    Command.GET_SYSTEM_SOFTWARE_VERSION: "text32 software_version",
}


def _exchanges() -> dict[int, Exchange]:
    requests = _REQUESTS | {Command[f"SET_{name}"]: layout for name, layout in _SET_AND_TOLD.items()}
    answers = _ANSWERS | {Command[f"GET_{name}"]: layout for name, layout in _SET_AND_TOLD.items()}
    return {command: Exchange.of(requests.get(command, ""), answers.get(command, "")) for command in Command}


EXCHANGES: Mapping[int, Exchange] = _exchanges()


def exchange(command: int) -> Exchange | None:
    """Return the layouts of a command, None for a number that the protocol does not assign."""
    return EXCHANGES.get(command)
