"""The linear view of a case: static equilibrium, natural frequencies, modes, frequency response, Campbell diagrams."""
