"""The physics tables by name; a new file here adds its table."""

from __future__ import annotations

import sys

from comparisons.discovery import classes_of
from comparisons.scene.physics.tables.physics_table import PhysicsTable

_tables = (table for table in classes_of(sys.modules[__name__], PhysicsTable) if table.key)
# In the order in which a plan names them.
TABLES: dict[str, type[PhysicsTable]] = {
    table.key: table for table in sorted(_tables, key=lambda table: table.place)
}
