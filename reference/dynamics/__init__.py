"""Motion with contact, without the reduced model.

- `collision`: impacts in closed form (Hertz, Deresiewicz), by quadrature, with radiated waves;
- `vibration`: a mass on a contact: course in time, resonance, backbone, flight, forced motion.
"""
