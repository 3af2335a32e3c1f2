"""MuJoCo's soft contact in a separate process: a ball pressed against a plane until it rests.

MuJoCo (https://mujoco.org, Apache-2) has no elastic bodies: a contact is a constraint that may be
violated, with a reference acceleration (`solref`) and an impedance i (`solimp`, constant here). At
rest the force is m k d/(1 - i): a spring whose stiffness is proportional to the mass m.

A ball of radius 1; forces per mass of order 1.
"""

from __future__ import annotations

import math
import time
from typing import Any

import mujoco
import numpy as np

SCENE = """
<mujoco>
  <option gravity="0 0 0" timestep="{step!r}"/>
  <default><geom condim="1" solref="{spring!r} {damper!r}" solimp="{i} {i} 1 0.5 1"/></default>
  <worldbody>
    <geom type="plane" size="5 5 1"/>
    <body pos="0 0 1">
      <joint type="slide" axis="0 0 1"/>
      <geom type="sphere" size="1" mass="{mass!r}"/>
    </body>
  </worldbody>
</mujoco>
"""
IMPEDANCE = 0.95
# In units of 1/sqrt(k), at critical damping; at rest when it moves a billionth of the overlap.
TIME_STEP, AT_REST, MOST_STEPS = 0.05, 1e-9, 100_000


def solve(problem: dict[str, Any]) -> dict[str, Any]:
    """Hold forces (k,) on a ball of radius 1, one after another.

    The problem: stiffness (k of `solref`), mass, forces. Returns penetration and force of the
    contact (k,), iterations (k,), unknowns, seconds, setup_seconds.
    """
    begin = time.perf_counter()
    frequency = math.sqrt(problem["stiffness"])
    model = mujoco.MjModel.from_xml_string(
        SCENE.format(
            step=TIME_STEP / frequency,
            spring=-float(problem["stiffness"]),
            damper=-2 * frequency,
            i=IMPEDANCE,
            mass=float(problem["mass"]),
        )
    )
    data = mujoco.MjData(model)
    ready = time.perf_counter()
    rows = []
    for force in problem["forces"]:
        data.qfrc_applied[0] = -force
        steps = 0
        while True:
            steps += 1
            mujoco.mj_step(model, data)
            depth = -float(data.qpos[0])
            if data.ncon and abs(data.qvel[0]) <= AT_REST * abs(depth) * frequency:
                break
            if steps == MOST_STEPS:
                raise RuntimeError(f"the ball did not come to rest in {MOST_STEPS} steps")
        carried = np.zeros(6)
        mujoco.mj_contactForce(model, data, 0, carried)
        rows.append((depth, float(carried[0]), steps))
    depth, carried, counts = np.array(rows).T
    return {
        "penetration": depth,
        "force": carried,
        "iterations": counts.astype(int),
        "unknowns": 1,
        "seconds": time.perf_counter() - begin,
        "setup_seconds": ready - begin,
    }
