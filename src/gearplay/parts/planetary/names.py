"""Names of the members of a planetary set, and the largest number of planets."""

from typing import Final

MEMBERS: Final = ("sun", "ring", "carrier")
MOST_PLANETS: Final = 24
