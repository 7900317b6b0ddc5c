"""An elastic support: linear springs and dampers between a rotor and the ground or a carrier."""
