"""Lengths whose rows tell everything that an effect may depend on, and what a diagnosis sees of them."""

from dataclasses import replace
from functools import cache

import numpy as np

from tests.helpers.diagnosis.point_scenes import scene_of
from tests.helpers.identification.synthetic import leg_campaign
from truepose.identification.problem.build import build

N = 60
PER_PLACEMENT, PER_INITIALISATION = 30, 6
CADENCE_S = 40.0
LEG_START = ("tool", "geometry")


def telling_legs(**changes):
    """Lengths from two placements of one base nest, initialised before every six of them."""
    campaign = leg_campaign(N)
    legs = campaign.legs
    told = {
        "stops": replace(legs.stops, time_s=CADENCE_S * np.arange(N)),
        "placement": 1 + np.arange(N) // PER_PLACEMENT,
        "initialisation": 1 + np.arange(N) // PER_INITIALISATION,
    }
    return replace(campaign, legs=replace(legs, **(told | changes)), ballbar_nominal_mm=300.0)


def leg_problem(campaign=None):
    """The problem of a campaign of legs with the geometry; that of the telling legs is placed once."""
    return _usual_problem() if campaign is None else build(campaign, LEG_START)


@cache
def _usual_problem():
    return build(telling_legs(), LEG_START)


def leg_scene(campaign=None, **changes):
    """The scene of a campaign of legs that was fitted with the geometry."""
    return scene_of(leg_problem(campaign), **changes)
