"""Who is closed where there are too many, and who never."""

import pytest

from truepose.app.connections import Census, Limits


class FakeConnection:
    def __init__(self, since_s=0.0, peer="127.0.0.1", slow=None):
        self.since_s = since_s
        self.peer = peer
        self.slow = slow
        self.is_cut = False

    def incomplete_since(self):
        return self.since_s

    def too_slow(self, now_s):
        return self.slow

    def cut(self):
        self.is_cut = True


def full(connections, limit=4, per_peer=256):
    census = Census(Limits(limit, per_peer))
    for connection in connections:
        census.admit(connection)
    return census


def cut(connections):
    return [number for number, connection in enumerate(connections) if connection.is_cut]


def test_of_a_proxy_more_get_in_than_of_another_computer():
    of_proxy = [FakeConnection(peer="192.168.1.2") for _ in range(4)]
    of_other = [FakeConnection(peer="192.168.1.3") for _ in range(4)]
    census = Census(Limits(16, 2), lambda peer: peer == "192.168.1.2")

    for connection in (*of_proxy, *of_other):
        census.admit(connection)

    assert cut(of_proxy) == []
    assert len(cut(of_other)) == 2


def test_a_newcomer_gets_in_and_the_one_that_waited_longest_goes():
    waiting = [FakeConnection(since_s) for since_s in (3.0, 1.0, 2.0, 4.0)]
    newcomer = FakeConnection(5.0)

    census = full([*waiting, newcomer])

    assert cut(waiting) == [1]
    assert not newcomer.is_cut
    assert len(census) == 4


def test_a_request_under_way_is_never_closed_for_a_newcomer():
    under_way = [FakeConnection(None) for _ in range(3)]
    waiting, newcomer = FakeConnection(1.0), FakeConnection(5.0)

    full([*under_way, waiting, newcomer])

    assert waiting.is_cut
    assert cut([*under_way, newcomer]) == []


def test_where_all_are_under_way_the_newcomer_goes():
    under_way = [FakeConnection(None) for _ in range(4)]
    newcomer = FakeConnection(5.0)

    census = full([*under_way, newcomer])

    assert newcomer.is_cut
    assert cut(under_way) == []
    assert len(census) == 4


def test_room_is_made_at_the_expense_of_the_peer_that_has_most():
    tablet = FakeConnection(0.0, "192.168.1.20")
    crowd = [FakeConnection(float(number), "192.168.1.66") for number in range(1, 4)]
    newcomer = FakeConnection(9.0, "192.168.1.30")

    full([tablet, *crowd, newcomer])

    assert not tablet.is_cut
    assert cut(crowd) == [0]


def test_another_computer_has_a_limit_of_its_own_and_loopback_has_not():
    far = [FakeConnection(float(number), "192.168.1.66") for number in range(3)]
    near = [FakeConnection(float(number)) for number in range(3)]

    full([*far, *near], limit=100, per_peer=2)

    assert cut(far) == [0]
    assert cut(near) == []


def test_a_flood_of_newcomers_is_met_in_batches():
    waiting = [FakeConnection(float(number)) for number in range(64)]

    census = full([*waiting, FakeConnection(99.0)], limit=64)

    assert cut(waiting) == [0, 1, 2, 3]
    assert len(census) == 61


def test_the_slow_are_closed_and_counted_by_reason():
    slow, quick = FakeConnection(slow="sent nothing"), FakeConnection()
    census = full([slow, quick])

    census.look(1.0)

    assert (slow.is_cut, quick.is_cut) == (True, False)
    assert census.take_closed() == {"sent nothing": 1}
    assert census.take_closed() == {}


def test_where_the_system_has_no_descriptors_left_some_are_closed():
    waiting = [FakeConnection(float(number)) for number in range(3)]

    full(waiting).out_of_descriptors()

    assert cut(waiting) == [0]


@pytest.mark.parametrize("times", [1, 2])
def test_leaving_is_counted_once(times):
    staying, leaving = FakeConnection(), FakeConnection()
    census = full([staying, leaving])

    for _ in range(times):
        census.leave(leaving)

    assert len(census) == 1
