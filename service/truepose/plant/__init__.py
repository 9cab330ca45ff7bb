"""A plant: collects what its cells have on record, and hands down what they are to have: no cell waits."""
