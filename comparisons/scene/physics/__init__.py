"""Physics beyond frictionless elastic contact: tables, valid combinations, load paths.

Scenes without these tables do not use this package.
"""
