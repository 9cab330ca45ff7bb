"""The contract suite: what every driver must keep to, asked of one on a bench that its author writes.

`pytest --pyargs truepose_drivers.contract --driver NAME` runs all of it in simulated time. That needs pytest,
which `truepose[contract]` brings; the cases themselves do without, and the night run asks them so.
"""
