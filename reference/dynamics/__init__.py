"""Motion with contact and friction, without the reduced model.

- `coulomb`: rigid blocks, springs, belts under Coulomb's set-valued law; closed forms of sliding,
  stick-slip and dry-friction oscillators;
- `event_driven.follow`: the motion of blocks, exact between the events;
- `moreau_jean.march`: the same in fixed time steps (Moreau and Jean);
- `collision`: impacts in closed form (Hertz, Deresiewicz) and by quadrature;
- `wave_impact`: impact that radiates waves;
- `vibration`: a mass on a contact: course in time, resonance, backbone, flight, forced motion.
"""
