"""What a reader may do about bytes that nobody foresaw: read them, or refuse them in its own words."""

import pytest


def assert_refused_at_worst(error, read, *given):
    """Fail where reading raises anything but `error`; return what was read, None where it was refused."""
    try:
        return read(*given)
    except error:
        return None
    except Exception as other:
        pytest.fail(f"{read} raises {other!r}")
