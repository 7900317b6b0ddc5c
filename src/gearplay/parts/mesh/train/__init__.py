"""Train of a case: the places and speeds of its rotors, by the parts that join and hold them."""
