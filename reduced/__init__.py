"""The 1-D model under test: contact reduced to a line on independent springs.

- `profiles`: three-dimensional shapes as equivalent one-dimensional profiles (exact transform,
  Gaussian radius, equal area, and the chapter's half-radius rule as printed);
- `springs`: a single contact, all loads at once (`indent`); the pressure from the spring forces,
  exact and as printed (`stress`);
- `rough`: spectra of surfaces and lines and the rules between them, rough lines on springs
  (`press`), the contacts of one line (`regions`), many realisations (`ensemble`), section 19.7
  from a map to its contact (`procedure`);
- `friction`: springs with stick and slip, for loading, for any path, and rolling;
- `film`: a lubricating film on springs;
- `adhesion`: the edge-stretch rule along a path, with snap-in, pull-off and losses;
- `plasticity`, `wear`: springs that yield, springs whose profile wears;
- `memory`: materials (Kelvin-Voigt, Maxwell, standard solid, Prony series), one spring that holds,
  lets go and catches, any history of depth or force on a row of them, impacts;
- `rubber`: a rough line sliding over viscoelastic springs: steady state, in time, and as printed;
- `motion`: the continuous friction law (19.1), a rigid mass on a contact (Fig. 19.4).

Inputs and outputs are arrays and numbers in consistent units; the package uses no files or scenes.
Arguments out of range are refused with one ValueError that names all of them; solvers that find no
answer raise `errors.ConvergenceError`.
"""
