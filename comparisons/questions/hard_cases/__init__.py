"""Hard cases: a catalogue of scenes that break solvers, with what each method must do there."""
