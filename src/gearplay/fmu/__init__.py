"""FMU export: a case as a functional mock-up unit, FMI 2.0 or 3.0 for co-simulation, in C."""
