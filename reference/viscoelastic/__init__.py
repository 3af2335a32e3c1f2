"""Contact with linear viscoelastic half-spaces: materials, quadratures of Lee-Radok and Ting."""
