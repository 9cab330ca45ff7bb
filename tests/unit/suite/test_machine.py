"""What a run says at its end about a machine that lacks something."""

from tests.helpers.machine import CHROMIUM, MEASURED_DATA, what_was_untested


def test_a_machine_that_has_everything_says_nothing():
    assert what_was_untested([]) == ""


def test_what_was_skipped_for_other_reasons_is_not_told():
    assert what_was_untested(["Skipped: a bridge knows three signals and no reasons"]) == ""


def test_a_bare_machine_says_in_one_line_what_it_could_not_test():
    skipped = [f"Skipped: {MEASURED_DATA.reason}"] * 31 + [f"Skipped: {CHROMIUM.reason}"]

    line = what_was_untested(skipped)

    assert line == (
        "Not tested on this machine: campaigns that were measured (TRUEPOSE_DATA does not name the folder of "
        "example campaigns; 31 skipped), pages in a browser (no Chromium is installed here; 1 skipped)."
    )
