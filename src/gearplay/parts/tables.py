"""Names of all tables and lists of a case that hold parts."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from gearplay.parts.bearing.schema import Bearing
from gearplay.parts.coupling.schema import Coupling
from gearplay.parts.protocol import Holder, Joint
from gearplay.parts.sleeve.schema import Sleeve
from gearplay.parts.support.schema import Support

HOLDERS: Final[Mapping[str, type[Holder]]] = MappingProxyType(
    {"sleeves": Sleeve, "bearings": Bearing, "supports": Support}
)
"""Tables by the names of the rotors that their parts hold."""
JOINTS: Final[Mapping[str, type[Joint]]] = MappingProxyType({"couplings": Coupling})
"""Lists of parts that connect rotors."""
