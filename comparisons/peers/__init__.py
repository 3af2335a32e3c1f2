"""Third-party solvers, run on the same problem in separate processes.

Their methods are in `comparisons.methods.peers`. The comparing process imports no peer.
"""
