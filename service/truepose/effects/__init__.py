"""One file per physical source of error; `registry` lists them.

An effect says which parameters it has and how each moves a *port* of the kinematic chain
(`ports`): a joint angle, a link quantity, the base, a nest. The chain turns ports into
positions and derivatives, once, in `truepose.identification.model.evaluation`.
"""
