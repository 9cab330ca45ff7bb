"""Sphere tests of noise alone: how often they say that it is noise."""

from tests.helpers.ballbar.spheres import IRB_120, sphere_campaign, stops_on_sphere
from truepose.judgement.sphere.judged import sphere_test


def test_noise_alone_is_said_to_be_noise():
    joints, nest = stops_on_sphere()

    def drawn(seed):
        campaign = sphere_campaign(IRB_120, joints_rad=joints, nest=nest, noise=1.0, seed=seed)
        (sphere,) = sphere_test(campaign, None).spheres
        return sphere

    tests = [drawn(seed) for seed in range(200)]

    for taught in (True, False):
        noise = [test.of("nominal", taught=taught).is_noise for test in tests]
        assert sum(noise) >= 190  # 198 on average; 190 is 5 standard deviations off
