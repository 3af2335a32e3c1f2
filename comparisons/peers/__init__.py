"""Half-space solvers of other people, each run in a process of its own on the same problem.

The methods of these solvers are in `comparisons.methods.peers`. Here they are
run: nothing of a peer is imported by the process that compares.
"""
