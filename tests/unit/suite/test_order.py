from tests.helpers.order import spread, turned


def in_order(*files):
    ranks = spread(files)
    return sorted(files, key=ranks.__getitem__)


def test_what_waits_lies_evenly_among_what_computes():
    waiting = ("browser/test_a.py", "browser/test_b.py")
    computing = tuple(f"system/test_{k}.py" for k in range(4))

    order = in_order(*waiting, *computing)

    assert [order.index(file) for file in waiting] == [1, 4]
    assert [file for file in order if file in computing] == list(computing)


def test_short_files_come_last():
    assert in_order("unit/test_a.py", "system/test_b.py", "browser/test_c.py")[-1] == "unit/test_a.py"


def test_without_a_browser_nothing_changes_its_place():
    files = ("contract/test_a.py", "integration/test_b.py", "unit/test_c.py", "unit/test_d.py")

    assert in_order(*files) == [*files]


def test_nothing_has_no_order():
    assert in_order() == []


def test_each_process_begins_with_other_files_and_leaves_none_out():
    files = ["a", "b", "c", "d", "e"]

    begun = [turned(files, share) for share in (0.0, 0.25, 0.5, 0.75)]

    assert [first for first, *_ in begun] == ["a", "b", "c", "d"]
    assert all(sorted(order) == files for order in begun)
    assert turned([], 0.75) == []
