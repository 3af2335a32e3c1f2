"""Half-space solvers of other people, each run in a process of its own on the same problem.

Here they are drivers: nothing of a peer is imported by the process that compares.
"""
