"""Content of model files, written by hand: what the simulator may rely on, and nothing of the service."""

ROWS = [
    (0.0, 0.0, 0.0, 290.0),
    (-90.0, 0.0, -90.0, 0.0),
    (0.0, 270.0, 0.0, 0.0),
    (-90.0, 70.0, 0.0, 302.0),
    (90.0, 0.0, 0.0, 0.0),
    (-90.0, 0.0, 180.0, 72.0),
]
AT_THE_WORLD = dict.fromkeys(("x_mm", "y_mm", "z_mm", "rx_deg", "ry_deg", "rz_deg"), 0.0)
_KEYS = ("alpha_deg", "a_mm", "theta_offset_deg", "d_mm")


def robot_document(**changes):
    return {
        "name": "ABB IRB 120",
        "dhm_nominal": [
            {"joint": joint, **dict(zip(_KEYS, row, strict=True)), "sign": 1}
            for joint, row in enumerate(ROWS, start=1)
        ],
        "masses": [{"frame": 4, "kg": 5.0, "cog_mm": [0.0, 0.0, -193.6]}],
        "gear_ratio": None,
        "typical_compliance_rad_per_Nmm": None,
        "robot_repeatability_mm": 0.0035,
        "calibration_ranges_deg": None,
        "joint_limits_deg": None,
        **changes,
    }


def model_document(*parameters, **changes):
    """A model with parameters (effect, name, value, unit); keywords replace keys."""
    return {
        "format": "truepose-model",
        "version": 1,
        "program_version": "9",
        "robot": robot_document(),
        "gravity_m_s2_world": [0.0, 0.0, -9.81],
        "effects": list(dict.fromkeys(effect for effect, *_ in parameters)),
        "base_in_world": AT_THE_WORLD,
        "tool_nests": [{"nest": 1, "centre_mm": [0.0, 0.0, 125.0]}],
        "instrument_in_world_mm": None,
        "repeatability_mm": 0.01,
        "torques_measured": False,
        "parameters": [
            {"effect": effect, "name": name, "value": value, "unit": unit, "standard_uncertainty": None}
            for effect, name, value, unit in parameters
        ],
        **changes,
    }
