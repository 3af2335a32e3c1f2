"""Hard cases: a catalogue of scenes that break solvers, with expected outcomes by method."""
