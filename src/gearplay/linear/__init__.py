"""Linear analysis of a case: static equilibrium, natural frequencies, frequency response, Campbell diagrams."""
