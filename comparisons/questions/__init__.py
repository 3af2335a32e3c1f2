"""What is asked: a study, claims, hard cases, calibration, regression, benchmarks."""
