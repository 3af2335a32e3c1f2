"""The questions: study, claims, hard cases, calibration, regression, benchmarks."""
