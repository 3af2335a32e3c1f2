"""Motion with contact and friction, without the reduced model.

- `coulomb`: rigid blocks, springs, belts under Coulomb's set-valued law; closed forms of sliding,
  stick-slip and dry-friction oscillators; their motion in fixed steps (Moreau and Jean);
- `event_driven.follow`: the motion of blocks, exact between the events;
- `collision`: impacts in closed form (Hertz, Deresiewicz), by quadrature, with radiated waves;
- `vibration`: a mass on a contact: course in time, resonance, backbone, flight, forced motion.
"""
