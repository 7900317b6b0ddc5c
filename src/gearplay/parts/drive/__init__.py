"""Drives and loads of rotors: servos, position loops, torques that vary."""
