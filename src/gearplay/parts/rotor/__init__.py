"""A rotor: a planar rigid body with its gears."""
