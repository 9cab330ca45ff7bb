"""The stated interval of what a correction gains, against proofs that are drawn."""

from tests.helpers.identification.proved import SCATTER_MM, model, visited
from truepose.correction.proof import proof_of


def test_the_interval_holds_the_gain_of_many_more_targets():
    true = proof_of(model(), visited(model(), n=1000, seed=9), SCATTER_MM).gain

    proofs = [proof_of(model(), visited(model(), seed=seed), SCATTER_MM) for seed in range(20)]

    inside = [proof.gain_interval_95[0] < true < proof.gain_interval_95[1] for proof in proofs]
    assert sum(inside) >= 16
