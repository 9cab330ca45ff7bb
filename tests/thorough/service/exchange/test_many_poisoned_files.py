"""Many more poisoned files of each kind are read, or refused, within the same bounds."""

import pytest

from tests.unit.service.exchange.test_poisoned_files import DRAWS, READERS, nothing_is_fitted, require_answer

__all__ = ["nothing_is_fitted"]  # a fixture
MANY = 200


@pytest.mark.parametrize("kind", READERS)
def test_every_poisoned_file_is_read_or_refused_in_its_own_time_and_memory(kind, tmp_path):
    for seed in range(DRAWS, MANY):
        require_answer(kind, seed, tmp_path)
