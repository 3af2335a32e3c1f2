"""Motion with contact and friction, without the reduced model.

- `blocks.blocks`: rigid blocks, springs, belts and Coulomb's set-valued law;
- `event_driven.follow`: their motion, exact between the events;
- `moreau_jean.march`: the same law in fixed time steps (Moreau and Jean);
- `friction_forms`: closed forms of sliding, stick-slip and dry-friction oscillators;
- `collision`: impacts in closed form (Hertz, Deresiewicz) and by quadrature;
- `course.course`: a mass on a contact over time, under any piecewise linear force;
- `oscillator`: a mass on a contact: resonance, backbone, flight, forced motion.
"""
