"""Case model: rotors, sleeves, meshes and runs, frozen and validated, with their geometry."""
