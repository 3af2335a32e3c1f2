"""Motion with contact, without the reduced model.

- `collision`: impacts in closed form (Hertz, Deresiewicz), by quadrature, along a course in time;
  what they radiate.
"""
