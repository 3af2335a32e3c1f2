"""The 1-D model under test: contact reduced to a line on independent springs.

- `profiles`: three-dimensional shapes as equivalent one-dimensional profiles (exact transform,
  Gaussian radius, equal area, and the chapter's half-radius rule as printed);
- `foundation.indent`: a single contact on springs, all loads at once;
- `adhesion`: the edge-stretch rule on springs along a path, with snap-in, pull-off and losses;
- `stress`: surface pressure from the springs, exact (`abel`) and as printed (`local_rule`, with the
  profile's own curvature; `one_radius_rule`, with one for the contact);
- `surface_spectrum`, `spectrum`: power spectra of surfaces, the two-to-one-dimensional rules and
  what they keep (`sum_rules`), synthesis of rough lines;
- `rough_line.press`: rough lines on springs, connected contacts, the area rule (19.29);
- `line_regions`: the contacts of one line one by one, and the stress rule on them;
- `ensemble.press_ensemble`: many realisations with their statistics;
- `friction_law`, `friction_motion`: the continuous friction law (19.1), rigid blocks under it;
- `contact_law`, `impact.strike`, `contact_motion.move`: a rigid mass on a contact (Fig. 19.4);
- `procedure.calculate`: section 19.7 from a map to its contact;
- `viscoelastic_models`: Kelvin-Voigt, Maxwell, standard solid and Prony series, their relaxation,
  creep, complex modulus and fit;
- `viscoelastic.indent_in_time`: any history of depth or force on springs, `harmonic_stiffness`;
- `viscoelastic_impact.impact`: a mass against them, its coefficient of restitution.

Arrays and numbers in consistent units go in and come out; nothing here knows of files or scenes.
"""
