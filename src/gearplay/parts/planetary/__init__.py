"""A planetary set, expanded into rotors, pins and meshes."""
