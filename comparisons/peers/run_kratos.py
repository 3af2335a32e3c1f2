"""Kratos' mortar contact in a separate process: a rigid cylinder on a block, in plane strain.

Kratos Multiphysics (https://github.com/KratosMultiphysics/Kratos, BSD-4) solves half of a block of
four-node elements, whose sides but the top are held, by an augmented Lagrangian with dual
multipliers. Strains are small, but contact is sought where the surface has gone, and its pressure
is a force over a deformed length.

A block of Young's modulus 1.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import KratosMultiphysics as KM  # noqa: N817 - its own examples have these names
import KratosMultiphysics.ContactStructuralMechanicsApplication as CSMA  # noqa: N817
import KratosMultiphysics.LinearSolversApplication  # for sparse_lu
import numpy as np
from KratosMultiphysics.StructuralMechanicsApplication import structural_mechanics_analysis

APPLICATION = "KratosMultiphysics.ContactStructuralMechanicsApplication"
LAW = "KratosMultiphysics.StructuralMechanicsApplication.LinearElasticPlaneStrain2DLaw"
# Chords of the cylinder to an element of the block, and its width over that of the touching part.
CHORDS, BEYOND = 3, 1.3


def solve(problem: dict[str, Any]) -> dict[str, Any]:
    """Press the parabolic cylinder z = x^2/(2 R) to a depth.

    The problem: x and depths (lines of the mesh, from the axis and from the surface), touching
    (number of the lines in x that may touch), radius, penetration, steps, poisson_ratio. Returns
    pressure (touching,), force (of both halves), unknowns, seconds.
    """
    begin = time.perf_counter()
    x, touching = np.array(problem["x"]), problem["touching"]
    wide = BEYOND * x[touching - 1]
    across = np.linspace(0, wide, int(CHORDS * np.ceil(wide / x[1])) + 1)
    bottom = across**2 / (2 * problem["radius"])
    # the slave side must lie wholly under the master
    block = _grid(x, -np.array(problem["depths"])[::-1, None], 1)
    cylinder = _grid(across, np.stack([bottom, bottom + x[1]]), 1 + block[1].size)
    slave, wall = block[1][-1, :touching], np.union1d(block[1][0], block[1][:, -1])
    quads = []
    for _, numbers in (block, cylinder):
        corners = [numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, 1:], numbers[1:, :-1]]
        quads.append(np.stack(corners, axis=-1).reshape(-1, 4))
    elements = [(key, *quad) for key in (1, 2) for quad in quads[key - 1].tolist()]
    split = len(quads[0])
    places = np.vstack([places for places, _ in (block, cylinder)]).tolist()
    text = [
        _listed("Properties 1", []),
        _listed("Properties 2", []),
        _listed("Nodes", ((k, *place, 0.0) for k, place in enumerate(places, 1))),
        _listed(
            "Elements SmallDisplacementElement2D4N",
            ((k, *element) for k, element in enumerate(elements, 1)),
        ),
        _part("Block", block[1], range(1, split + 1)),
        _part("Cylinder", cylinder[1], range(split + 1, len(elements) + 1)),
        _part("Slave", slave),
        _part("Both", np.concatenate([slave, cylinder[1][0]])),  # "Contact" is Kratos' own
        _part("Axis", block[1][:, 0]),
        _part("Wall", wall),
    ]
    Path("mesh.mdpa").write_text("\n".join(text), encoding="utf-8")
    elastic = {"YOUNG_MODULUS": 1.0, "POISSON_RATIO": problem["poisson_ratio"], "THICKNESS": 1.0}
    material = {"constitutive_law": {"name": LAW}, "Variables": elastic, "Tables": {}}
    materials = [
        {"model_part_name": f"Structure.{part}", "properties_id": key, "Material": material}
        for key, part in ((1, "Block"), (2, "Cylinder"))
    ]
    Path("materials.json").write_text(json.dumps({"properties": materials}), encoding="utf-8")
    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    model = KM.Model()
    settings = KM.Parameters(json.dumps(_settings(problem["penetration"], problem["steps"])))
    structural_mechanics_analysis.StructuralMechanicsAnalysis(model, settings).Run()
    structure = model["Structure"]

    def values(numbers: Any, variable: Any) -> np.ndarray:
        nodes = map(structure.GetNode, np.ravel(numbers).tolist())
        return np.array([node.GetSolutionStepValue(variable) for node in nodes])

    multiplier = values(slave, CSMA.LAGRANGE_MULTIPLIER_CONTACT_PRESSURE)
    return {
        "pressure": -structure.ProcessInfo[KM.SCALE_FACTOR] * multiplier,
        "force": 2 * float(values(wall, KM.REACTION_Y).sum()),
        "unknowns": 2 * block[1].size,
        "seconds": time.perf_counter() - begin,
    }


def _settings(penetration: float, steps: int) -> dict[str, Any]:
    def held(part: str, value: list[Any]) -> dict[str, Any]:
        return {
            "python_module": "assign_vector_variable_process",
            "kratos_module": "KratosMultiphysics",
            "Parameters": {
                "model_part_name": f"Structure.{part}",
                "variable_name": "DISPLACEMENT",
                "constrained": [one is not None for one in value],
                "value": value,
            },
        }

    contact = {
        "model_part_name": "Structure",
        "assume_master_slave": {"0": ["Slave"]},
        "contact_model_part": {"0": ["Both"]},
        "contact_type": "Frictionless",
        "search_parameters": {"search_factor": 10.0, "active_check_factor": 1.0},
    }
    return {
        "problem_data": {
            "problem_name": "line",
            "parallel_type": "OpenMP",
            "echo_level": 0,
            "start_time": 0.0,
            "end_time": steps - 0.5,
        },
        "solver_settings": {
            "solver_type": "Static",
            "model_part_name": "Structure",
            "domain_size": 2,
            "analysis_type": "non_linear",
            "model_import_settings": {"input_type": "mdpa", "input_filename": "mesh"},
            "material_import_settings": {"materials_filename": "materials.json"},
            "contact_settings": {
                "mortar_type": "ALMContactFrictionless",
                "fancy_convergence_criterion": False,
            },
            "time_stepping": {"time_step": 1.0},
            "clear_storage": True,
            "reform_dofs_at_each_step": True,
            "max_iteration": 60,
            "convergence_criterion": "contact_residual_criterion",
            "residual_relative_tolerance": 1e-9,
            "residual_absolute_tolerance": 1e-14,
            "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
        },
        "processes": {
            "constraints": [
                held("Axis", [0.0, None, 0.0]),
                held("Wall", [0.0, 0.0, 0.0]),
                held("Cylinder", [0.0, f"-{penetration!r}*t/{steps}", 0.0]),
            ],
            "contact": [
                {
                    "python_module": "alm_contact_process",
                    "kratos_module": APPLICATION,
                    "Parameters": contact,
                }
            ],
        },
    }


def _grid(x: np.ndarray, z: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the nodes on rows of z, and their numbers (rows, x)."""
    places = np.stack(np.broadcast_arrays(x, z), axis=-1)
    return places.reshape(-1, 2), first + np.arange(places[..., 0].size).reshape(-1, x.size)


def _listed(title: str, rows: Iterable[Iterable[Any]]) -> str:
    """Return a block of an mdpa file."""
    lines = (" ".join(map(repr, row)) for row in rows)
    return "\n".join([f"Begin {title}", *lines, f"End {title.split()[0]}"])


def _part(name: str, nodes: np.ndarray, elements: Iterable[int] = ()) -> str:
    given = _listed("SubModelPartNodes", ((k,) for k in nodes.ravel().tolist()))
    cells = _listed("SubModelPartElements", ((k,) for k in elements))
    return "\n".join([f"Begin SubModelPart {name}", given, cells, "End SubModelPart"])
