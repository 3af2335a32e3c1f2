"""The 1-D model under test: contact reduced to a line on independent springs.

- `profiles`: three-dimensional shapes as equivalent one-dimensional profiles (exact transform,
  Gaussian radius, equal area, and the chapter's half-radius rule as printed);
- `foundation.indent`: a single contact on springs, all loads at once;
- `stress`: surface pressure from the springs, exact (`abel`) and as printed (`local_rule`);
- `spectrum`: power spectra of surfaces, the two-to-one-dimensional rule, synthesis of rough lines;
- `rough_line.press`: rough lines on springs, connected contacts, the area rule (19.29).

Arrays and numbers in consistent units go in and come out; nothing here knows of files or scenes.
"""
