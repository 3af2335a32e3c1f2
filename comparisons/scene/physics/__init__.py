"""Physics beyond frictionless elastic contact: its tables, what goes together, what is walked.

A scene without these tables takes the path it always took; nothing here is asked for it.
"""

from __future__ import annotations

from comparisons.scene.physics.tables import PHYSICS, Adhesion, Dynamics, Friction, Sliding
from comparisons.scene.physics.viscoelastic import Viscoelastic

__all__ = ["PHYSICS", "Adhesion", "Dynamics", "Friction", "Sliding", "Viscoelastic"]
