"""The questions: study, claims, hard cases, calibration, check, benchmarks."""
