"""What the arm truly does: screw axes, loads, equilibrium. Pure functions on arrays; knows no instrument.

The route is another one than the identified model's on purpose (products of exponentials about axes
read off the makers' drawings), so that agreement between the two proves something.
"""
