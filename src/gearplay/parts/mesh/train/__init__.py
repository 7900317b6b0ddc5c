"""A train: the rotors of a case with the parts that join and hold them, their places, speeds and static loads."""
