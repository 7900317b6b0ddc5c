"""What joins rotors to each other and to the ground: one file an element, `table` lists them."""
