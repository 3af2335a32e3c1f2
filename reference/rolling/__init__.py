"""Steady rolling of a rigid roller with Coulomb friction and creep, seen from the contact.

- `roll`: pressed and rolled (`roll.roll`), tractions at given bounds on any elastic surface
  (`roll.steady`), and step by step from any state (`roll.roll_on`);
- `creep_theories`: the limit of small creep, Kalker's table, and FASTSIM.
"""
