"""Physics beyond frictionless elastic contact: its tables, what goes together, what is walked.

A scene without these tables takes the path it always took; nothing here is asked for it.
"""
