"""The proof move on the simulated cell, over its protocols: drivers, sessions, registration and all.

`python -m tests.studies.correction.proof_move --seeds 3` calibrates with 50 configurations, judges the
model by 100 more, then visits targets without and with correction. The figure is the error after
correction over the model's own held-out error: 1 where correcting costs nothing.
"""

import asyncio
import sys

from tests.studies.accuracy.measured_cell import prove_in_cell
from tests.studies.running import study_options


def main() -> int:
    """Print a line per cell; status 1 where a proof fails."""
    options = study_options(__doc__, scenario="irb120-tilted", seeds=3, targets=60)
    proved = True
    for seed in range(1, options.seeds + 1):
        found, proof = asyncio.run(prove_in_cell(options.scenario, seed, 50, 100, options.targets))
        held_out = found.validation.identified.mean_mm if found.validation else float("nan")
        low, high = proof.gain_interval_95
        sys.stdout.write(
            f"seed {seed}: mean {proof.before.mean_mm:.3f} -> {proof.after.mean_mm:.4f} mm, gain "
            f"{proof.gain:.1f} ({low:.1f} .. {high:.1f}), promised {proof.promised_mm:.4f}, "
            f"held out {held_out:.4f}: {proof.after.mean_mm / held_out:.3f}; "
            f"foretold share {proof.foretold_share:.3f}\n"
        )
        sys.stdout.flush()
        proved = proved and proof.proved
    return 0 if proved else 1


if __name__ == "__main__":
    sys.exit(main())
