"""The emScon dialogue in exact bytes, packed here by hand from the header's tables."""

import struct

import numpy as np
import pytest

from tests.unit.simulators.instruments.trackers.emscon_server import (
    INCH,
    MILLIMETER,
    NO_DISTANCE,
    NOT_IMPLEMENTED,
    NOT_INITIALIZED,
    OK,
    Server,
    answer,
    error,
    event,
)
from truepose_drivers.leica_emscon.protocol import StatusChange, encode, exchange
from truepose_simulators.faults.kinds import BeamBroken, TrackerBlinded, TrackerCut, TrackerSilent
from truepose_simulators.instruments.leica_emscon.settings import CutShort, HangUp
from truepose_simulators.instruments.tracker import TrackerSetup, in_tracker_frame


@pytest.fixture
def server(make_cell):
    return Server(make_cell(seed=2))


async def test_initialize_is_answered_as_the_notes_on_the_protocol_write_it_out(server):
    assert await server.ask(7) == [bytes.fromhex("10000000 00000000 07000000 00000000")]


@pytest.mark.parametrize("command", [49, 51, 53, 54, 63, 66, 124, 8])
async def test_before_initialize_the_tracker_neither_moves_nor_measures(server, command):
    members = {63: struct.pack("<d", 2000.0)}.get(command, b"")

    (packet,) = await server.ask(command, members)

    assert struct.unpack_from("<iIII", packet)[1:] == (0, command, NOT_INITIALIZED)


async def test_system_status_tells_start_up_and_the_serial_number(server):
    (before,) = await server.ask(1)
    await server.ask(7)

    (after,) = await server.ask(1)

    # last status, tracker 4 -> 5, laser ready 3, ADM ready 2, version, weather station 2, flags 0, serial
    status = (OK, 4, 3, 2, 3, 6, 412, 2, 0, 390_002)
    assert before == answer(1, OK, struct.pack("<10i", *status))
    assert after == answer(1, OK, struct.pack("<10i", OK, 5, *status[2:]))


async def test_the_last_status_is_kept_for_whoever_asks(server):
    await server.ask(49)

    (packet,) = await server.ask(1)

    assert struct.unpack_from("<i", packet, 16) == (NOT_INITIALIZED,)


async def test_a_measurement_is_answered_at_once_and_followed_by_the_short_result(server):
    await server.start()
    await server.go_to_fixed_nest(1)
    true = in_tracker_frame(server.cell.tracker.frame, server.cell.fixed_nests_mm()[0])
    started_s = server.cell.clock.now_s

    accepted, result = await server.ask(49)

    assert accepted == answer(49)
    size, kind, status, mode, is_try = struct.unpack_from("<iIIii", result)
    assert (size, kind, status, mode, is_try) == (156, 2, OK, 0, 0)
    values = struct.unpack_from("<17d", result, 20)
    # 0.017 mm across the beam at 2 m, 4.5 sigma with the collimation.
    assert values[:3] == pytest.approx(true, abs=0.08)
    assert values[6] == pytest.approx(np.sqrt(np.sum(np.square(values[3:6]))), rel=1e-9)
    assert values[14:] == pytest.approx((23.0, 1013.25, 45.0), abs=1.0)
    assert server.cell.clock.now_s - started_s == pytest.approx(1.0, abs=1e-9)  # default measuring time


async def test_the_extended_statistic_mode_asks_for_the_long_result(server):
    await server.start()
    await server.ask(80, struct.pack("<2i", 1, 1))

    _, result = await server.ask(49)

    assert struct.unpack_from("<iII", result) == (204, 9, OK)
    values = struct.unpack_from("<23d", result, 20)
    std, covariance = np.array(values[3:6]), values[7:10]
    matrix = np.diag(std**2)
    matrix[np.triu_indices(3, 1)] = covariance
    matrix[np.tril_indices(3, -1)] = covariance[0], covariance[1], covariance[2]
    assert (np.linalg.eigvalsh(matrix) > 0).all()


async def test_the_measuring_time_is_the_one_that_was_set(server):
    await server.start()
    await server.ask(28, struct.pack("<2i", 3000, 1))
    started_s = server.cell.clock.now_s

    await server.ask(49)

    assert server.cell.clock.now_s - started_s == pytest.approx(3.0, abs=1e-9)
    assert await server.ask(29) == [answer(29, OK, struct.pack("<2i", 3000, 1))]


async def test_without_a_reflector_a_measurement_is_refused(server):
    await server.start()
    await server.ask(58, struct.pack("<3d", 1000.0, 0.0, 0.0))  # PointLaser locks on nothing

    assert await server.ask(49) == [answer(49, NO_DISTANCE)]
    assert await server.ask(2) == [answer(2, OK, struct.pack("<i", 0))]


async def test_after_initialize_the_home_reflector_can_be_measured(server):
    await server.start()

    _, result = await server.ask(49)

    assert struct.unpack_from("<3d", result, 20) == pytest.approx((150.0, 0.0, -60.0), abs=0.08)


async def test_units_after_power_up_are_metre_and_radian(server):
    await server.ask(7)

    assert await server.ask(6) == [answer(6, OK, struct.pack("<5i", 0, 0, 0, 0, 0))]
    _, result = await server.ask(49)
    assert struct.unpack_from("<3d", result, 20) == pytest.approx((0.150, 0.0, -0.060), abs=8e-5)


async def test_lengths_follow_the_units_in_both_directions(server):
    await server.start(INCH)
    target = in_tracker_frame(server.cell.tracker.frame, server.cell.fixed_nests_mm()[1]) / 25.4

    found = await server.ask(55, struct.pack("<3di", *target, 1))
    _, result = await server.ask(49)
    (reflector, *_) = await server.ask(42)

    assert found == [answer(55)]
    assert struct.unpack_from("<3d", result, 20) == pytest.approx(target, abs=0.08 / 25.4)
    assert struct.unpack_from("<d", reflector, 28) == pytest.approx((0.25,), rel=1e-12)


async def test_a_stored_length_stays_the_same_length_when_the_unit_changes(server):
    await server.start(MILLIMETER)
    await server.ask(43, struct.pack("<di", 127.0, 5000))

    await server.ask(5, struct.pack("<5i", INCH, 0, 1, 4, 0))

    (packet,) = await server.ask(44)
    assert struct.unpack_from("<di", packet, 16) == (pytest.approx(5.0), 5000)
    (air,) = await server.ask(21)
    fahrenheit, psi, _ = struct.unpack_from("<3d", air, 16)
    assert fahrenheit == pytest.approx(73.4, abs=1.0)  # 23 C with 0.3 K of wave and sensor noise
    assert psi == pytest.approx(14.696, abs=1e-3)  # standard atmosphere


@pytest.mark.parametrize("kind", range(1, 8))
async def test_every_coordinate_type_shows_the_same_point_and_takes_it_back(server, kind):
    await server.start()
    await server.go_to_fixed_nest(2)
    x, y, z = in_tracker_frame(server.cell.tracker.frame, server.cell.fixed_nests_mm()[1])
    bearing, radius, distance = np.arctan2(y, x), np.hypot(x, y), np.linalg.norm((x, y, z))
    zenith = np.arctan2(radius, z)
    expected = {
        1: (-x, y, z),
        2: (x, -y, z),
        3: (x, y, -z),
        4: (radius, -bearing, z),
        5: (radius, bearing, z),
        6: (-bearing, zenith, distance),
        7: (bearing, zenith, distance),
    }[kind]

    await server.ask(26, struct.pack("<i", kind))
    _, result = await server.ask(49)
    shown = struct.unpack_from("<3d", result, 20)
    back = await server.ask(55, struct.pack("<3di", *expected, 1))

    assert shown == pytest.approx(expected, abs=0.08)
    assert back == [answer(55)]


async def test_stated_deviations_follow_the_coordinate_type(server):
    await server.start()
    await server.go_to_fixed_nest(2)
    distance = np.linalg.norm(in_tracker_frame(server.cell.tracker.frame, server.cell.fixed_nests_mm()[1]))

    await server.ask(26, struct.pack("<i", 7))
    _, result = await server.ask(49)

    apriori = struct.unpack_from("<3d", result, 20 + 10 * 8)
    across = 0.010 + 0.0035 * distance / 1000
    # Zenith: across over distance. Distance: along the beam. True place and reading differ by 1e-5.
    assert apriori[1] == pytest.approx(across / distance, rel=1e-4)
    assert apriori[2] == pytest.approx(0.008 + 0.0008 * distance / 1000, rel=1e-4)


async def test_orientation_and_transformation_apply_only_when_their_flags_are_set(server):
    await server.start()
    await server.go_to_fixed_nest(1)
    x, y, z = in_tracker_frame(server.cell.tracker.frame, server.cell.fixed_nests_mm()[0])
    quarter = np.pi / 2
    await server.ask(12, struct.pack("<6d", 1000.0, 0.0, 0.0, 0.0, 0.0, quarter))
    await server.ask(14, struct.pack("<7d", 0.0, 500.0, 0.0, 0.0, 0.0, 0.0, 2.0))

    shown = {}
    for transformation, orientation in ((0, 0), (0, 1), (1, 1)):
        await server.ask(47, struct.pack("<9i", 2, transformation, orientation, 1, 0, 0, 0, 1, 0))
        _, result = await server.ask(49)
        shown[transformation, orientation] = struct.unpack_from("<3d", result, 20)

    assert shown[0, 0] == pytest.approx((x, y, z), abs=0.08)
    assert shown[0, 1] == pytest.approx((1000.0 - y, x, z), abs=0.08)
    assert shown[1, 1] == pytest.approx((2 * (1000.0 - y), 2 * (x - 500.0), 2 * z), abs=0.16)


async def test_setters_announce_themselves_once_messages_are_asked_for(server):
    quiet = await server.ask(26, struct.pack("<i", 0))
    settings = await server.ask(47, struct.pack("<9i", 2, 0, 0, 1, 1, 0, 0, 1, 0))

    assert quiet == [answer(26)]
    assert settings == [answer(47), event(8)]
    assert await server.ask(5, struct.pack("<5i", 1, 0, 0, 0, 0)) == [answer(5), event(6)]
    assert await server.ask(24, struct.pack("<i", 0)) == [answer(24), event(17)]
    assert await server.ask(28, struct.pack("<2i", 500, 0)) == [answer(28), event(18)]
    assert await server.ask(40, struct.pack("<i", 1)) == [answer(40), event(7)]
    assert await server.ask(80, struct.pack("<2i", 0, 0)) == [answer(80), event(24)]
    await server.ask(7)
    accepted, busy, _, ready = await server.ask(49)
    assert (accepted, busy, ready) == (answer(49), event(26), event(27))
    assert await server.ask(53) == [answer(53), event(31)]
    assert await server.ask(52) == [answer(52), event(27)]


@pytest.mark.parametrize(
    ("command", "members", "status"),
    [
        (5, struct.pack("<5i", 9, 0, 0, 0, 0), 4),
        (5, struct.pack("<5i", 1, 0, 0, 9, 0), 7),
        (26, struct.pack("<i", 8), 4),
        (24, struct.pack("<i", 1), NOT_IMPLEMENTED),  # continuous: an AT40x has none
        (24, struct.pack("<i", 12), 4),
        (28, struct.pack("<2i", 0, 0), 4),
        (40, struct.pack("<i", 99), 4),
        (43, struct.pack("<di", -1.0, 1000), 4),
        (43, struct.pack("<di", 10.0, 0), 5),
        (14, struct.pack("<7d", 0, 0, 0, 0, 0, 0, 0.0), 10),
        (12, struct.pack("<6d", 0, float("nan"), 0, 0, 0, 0), 5),
        (79, struct.pack("<i", 2), 56),
        (121, struct.pack("<i", 77), 4),
        (120, struct.pack("<2i", 200, 11), 5),
        (101, struct.pack("<i", 0), NOT_IMPLEMENTED),
        (104, b"", NOT_IMPLEMENTED),
        (30, struct.pack("<4i", 1, 0, 0, 0), NOT_IMPLEMENTED),
        (50, b"", NOT_IMPLEMENTED),  # a number that is not assigned
        (9999, b"", NOT_IMPLEMENTED),
    ],
)
async def test_a_value_or_command_that_the_tracker_lacks_is_refused(server, command, members, status):
    (packet,) = await server.ask(command, members)

    assert struct.unpack_from("<III", packet, 4) == (0, command, status)


async def test_a_failed_answer_has_its_full_size_with_zeros(server):
    (packet,) = await server.ask(66)

    assert packet == answer(66, NOT_INITIALIZED, bytes(16))


async def test_reflectors_come_one_a_packet_with_the_total_in_each(server):
    packets = await server.ask(42)

    assert len(packets) == 4
    for number, packet in enumerate(packets, start=1):
        assert struct.unpack_from("<iIIIii", packet) == (100, 0, 42, OK, 4, number)
    assert packets[0][36:100].decode("utf-16-le").rstrip("\0") == "RRR 0.5in"
    assert await server.ask(40, struct.pack("<i", 4)) == [answer(40)]
    assert await server.ask(41) == [answer(41, OK, struct.pack("<i", 4))]


async def test_a_failed_search_is_an_error_packet_after_its_time_out(server):
    await server.start()
    await server.ask(58, struct.pack("<3d", 0.0, 0.0, 2000.0))  # straight up
    await server.ask(43, struct.pack("<di", 20.0, 7000))
    started_s = server.cell.clock.now_s

    assert await server.ask(63, struct.pack("<d", 2000.0)) == [error(63, NO_DISTANCE)]
    assert server.cell.clock.now_s - started_s == pytest.approx(7.0, abs=1e-9)


async def test_going_to_an_empty_place_is_refused_and_leaves_nothing_locked(server):
    await server.start()

    assert await server.ask(55, struct.pack("<3di", 0.0, 0.0, 2000.0, 1)) == [answer(55, NO_DISTANCE)]
    assert await server.ask(49) == [answer(49, NO_DISTANCE)]


@pytest.mark.parametrize(
    "aim", [(0.0, 0.0, 0.0), (float("nan"), 0.0, 1.0), (float("inf"), 0, 0), (1e300, 0, 0)]
)
async def test_a_position_that_is_none_is_refused(server, aim):
    await server.start()

    assert await server.ask(55, struct.pack("<3di", *aim, 1)) == [answer(55, 4)]


@pytest.mark.parametrize("command", [56, 57, 59, 63])
async def test_an_angle_or_distance_that_is_no_number_is_refused(server, command):
    await server.start()
    members = bytearray(exchange(command).request.size)
    struct.pack_into("<d", members, 0, float("inf"))

    assert await server.ask(command, bytes(members)) == [answer(command, 4)]


async def test_the_search_radius_decides_what_a_search_finds(server):
    await server.start()
    beside = in_tracker_frame(server.cell.tracker.frame, server.cell.fixed_nests_mm()[0] + (0.0, 0.0, 30.0))

    await server.ask(43, struct.pack("<di", 10.0, 1000))
    narrow = await server.ask(55, struct.pack("<3di", *beside, 1))
    await server.ask(43, struct.pack("<di", 40.0, 1000))
    wide = await server.ask(55, struct.pack("<3di", *beside, 1))

    assert (narrow, wide) == ([answer(55, NO_DISTANCE)], [answer(55)])


async def test_look_for_target_returns_the_direction_of_what_it_finds(server):
    await server.start()
    x, y, z = in_tracker_frame(server.cell.tracker.frame, server.cell.fixed_nests_mm()[2])

    (found,) = await server.ask(65, struct.pack("<4d", x + 5.0, y, z, 50.0))
    (direction,) = await server.ask(66)

    angles = struct.unpack_from("<2d", found, 16)
    assert angles == pytest.approx((np.arctan2(y, x), np.arctan2(np.hypot(x, y), z)), abs=1e-9)
    assert direction[16:] == found[16:]


async def test_go_and_measure_is_one_answer_and_the_result(server):
    await server.start()
    target = in_tracker_frame(server.cell.tracker.frame, server.cell.fixed_nests_mm()[1])

    accepted, result = await server.ask(135, struct.pack("<3d", *target))

    assert accepted == answer(135)
    assert struct.unpack_from("<3d", result, 20) == pytest.approx(target, abs=0.08)


async def test_both_faces_measure_the_same_point_within_their_error(make_cell):
    server = Server(make_cell(seed=2, tracker=TrackerSetup(two_face_rad=1e-4)))
    await server.start()
    await server.go_to_fixed_nest(1)
    faces = []
    for _ in range(2):
        _, result = await server.ask(49)
        faces.append(struct.unpack_from("<3d", result, 20))
        assert await server.ask(53) == [answer(53)]

    assert await server.ask(98) == [answer(98, OK, struct.pack("<i", 1))]
    distance = np.linalg.norm(faces[0])
    # 1e-4 rad twice, horizontally and vertically, and 0.017 mm of noise in each of four numbers.
    assert np.linalg.norm(np.subtract(*faces)) == pytest.approx(2e-4 * np.sqrt(2) * distance, abs=0.1)


async def test_the_level_reads_the_tilt_of_the_stand(server):
    await server.start()

    (packet,) = await server.ask(51)

    size, kind, status, level = struct.unpack_from("<iIIi", packet)
    assert (size, kind, status, level) == (40, 6, OK, 0)
    x_tilt, y_tilt, _ = struct.unpack_from("<3d", packet, 16)
    vertical = server.cell.tracker.frame[2, :3]
    assert (-np.sin(x_tilt), np.sin(y_tilt)) == pytest.approx((vertical[1], vertical[0]), abs=1e-12)


async def test_a_broken_beam_is_an_error_packet_in_place_of_the_result(server):
    await server.start()
    server.cell.faults.add(BeamBroken(reading=2))
    await server.ask(49)

    assert await server.ask(49) == [answer(49), error(49, NO_DISTANCE)]
    assert await server.ask(49) == [answer(49, NO_DISTANCE)]  # the reflector must be found again
    await server.ask(54)
    assert len(await server.ask(49)) == 2


async def test_a_silent_tracker_accepts_and_says_no_more(server):
    await server.start()
    server.cell.faults.add(TrackerSilent(reading=1))

    assert await server.ask(49) == [answer(49)]


async def test_a_cut_stream_breaks_inside_the_result(server):
    await server.start()
    server.cell.faults.add(TrackerCut(reading=1))

    accepted, cut = await server.ask(49)

    assert accepted == answer(49)
    assert isinstance(cut, CutShort)
    assert len(encode(cut.packet)) == 156


async def test_a_blinded_tracker_finds_nothing_and_loses_what_it_had(server):
    await server.start()
    await server.go_to_fixed_nest(1)
    server.cell.faults.add(TrackerBlinded())

    assert await server.ask(49) == [answer(49, NO_DISTANCE)]
    assert await server.go_to_fixed_nest(1) == [answer(55, NO_DISTANCE)]
    assert await server.ask(54) == [answer(54, NO_DISTANCE)]


async def test_system_parameters_can_be_set_and_asked(server):
    assert await server.ask(121, struct.pack("<i", 5000)) == [answer(121, OK, struct.pack("<2i", 5000, 110))]
    assert await server.ask(120, struct.pack("<2i", 5000, 50)) == [
        answer(120, 4)
    ]  # the battery is no setting
    assert await server.ask(120, struct.pack("<2i", 200, 3)) == [answer(120)]
    assert await server.ask(121, struct.pack("<i", 200)) == [answer(121, OK, struct.pack("<2i", 200, 3))]


async def test_restoring_startup_conditions_takes_every_setting_back(server):
    await server.start(INCH)
    await server.ask(28, struct.pack("<2i", 3000, 1))

    await server.ask(134)

    assert await server.ask(6) == [answer(6, OK, struct.pack("<5i", 0, 0, 0, 0, 0))]
    assert await server.ask(29) == [answer(29, OK, struct.pack("<2i", 1000, 1))]


async def test_set_air_counts_only_while_the_weather_station_is_off(server):
    await server.ask(20, struct.pack("<3d", 30.0, 900.0, 10.0))
    (sensed,) = await server.ask(21)
    await server.ask(47, struct.pack("<9i", 0, 0, 0, 1, 0, 0, 0, 1, 0))

    (stored,) = await server.ask(21)

    assert struct.unpack_from("<d", sensed, 16)[0] == pytest.approx(23.0, abs=1.0)
    assert struct.unpack_from("<3d", stored, 16) == (30.0, 900.0, 10.0)


async def test_exit_application_is_answered_and_hangs_up(server):
    accepted, hang_up = await server.ask(0)

    assert accepted == answer(0)
    assert isinstance(hang_up, HangUp)


@pytest.mark.parametrize("command", range(143))
async def test_every_command_of_the_table_is_answered_in_some_way(server, command):
    await server.start()
    layouts = exchange(command)
    members = bytes(layouts.request.size) if layouts else b""

    packets = await server.ask(command, members)

    assert packets
    assert not any(isinstance(packet, StatusChange) for packet in packets)
    (size, kind) = struct.unpack_from("<iI", packets[0])
    assert size == len(packets[0])
    if kind == 0 and layouts:
        assert size == 16 + layouts.answer.size
