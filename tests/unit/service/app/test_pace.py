from truepose.app.connections import Pace


def test_nothing_is_too_slow_within_its_grace():
    pace = Pace(bytes_per_s=10.0, grace_s=5.0)
    pace.begin(100.0)

    assert pace.is_behind(100.1)
    assert not pace.too_slow(105.0)
    assert pace.too_slow(105.1)


def test_a_trickle_is_too_slow_and_a_stream_is_not():
    pace = Pace(bytes_per_s=10.0, grace_s=5.0)
    pace.begin(0.0)
    for _ in range(100):
        pace.move(1)

    assert not pace.too_slow(15.0)
    assert pace.too_slow(15.1)


def test_it_counts_anew_after_it_has_begun_anew():
    pace = Pace(bytes_per_s=10.0, grace_s=5.0)
    pace.begin(0.0)
    pace.move(1000)

    pace.begin(50.0)

    assert pace.too_slow(56.0)
    assert pace.lasted(56.0) == 6.0
