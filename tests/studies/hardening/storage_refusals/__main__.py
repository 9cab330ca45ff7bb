"""Sessions whose database refuses at a random moment: full, locked, removed, without room for a byte.

`python -m tests.studies.hardening.storage_refusals --out DIR [--runs N] [--seed N] [--lock-s S]
[--processes N]` runs half of the sessions with a tracker and devices that answer at once, half with a
ballbar, the service as a process, and hands. At the end each reading that was shown and each line that was
acknowledged must be in the database, unchanged and once, and the session must have finished, or ended as
asked, without a restart.
"""

from tests.studies.hardening.storage_refusals.outcome import told
from tests.studies.hardening.storage_refusals.study import refusals
from tests.studies.running import from_command_line

if __name__ == "__main__":
    from_command_line(__doc__, "storage_refusals", refusals, told, runs=100, seed=1, lock_s=60.0, processes=2)
