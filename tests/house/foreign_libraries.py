"""A contract for import-linter: which libraries from elsewhere each room may import; one that is not listed may import none."""

from importlinter import Contract, ContractCheck, fields, output
from importlinter.domain.fields import StringField


class ForeignLibraries(Contract):
    """Each of ``rooms`` reads ``room: library library ...``; the standard library is free, as far as ``standard`` leaves it."""

    rooms = fields.ListField(subfield=StringField())
    root = StringField()

    def check(self, graph, verbose):  # type: ignore[no-untyped-def]
        """Return what rooms import beyond their list, and what they list and do not import."""
        import sys

        allowed = {
            name.strip(): set(libraries.split())
            for name, _, libraries in (line.partition(":") for line in self.rooms)
        }
        used: dict[str, set[str]] = {name: set() for name in allowed}
        beyond = []
        for module in sorted(graph.modules):
            if module != self.root and not module.startswith(f"{self.root}."):
                continue
            room = module.split(".")[1] if "." in module else self.root
            for imported in sorted(graph.find_modules_directly_imported_by(module)):
                library = imported.partition(".")[0]
                if library == self.root or library in sys.stdlib_module_names:
                    continue
                used.setdefault(room, set()).add(library)
                if library not in allowed.get(room, set()):
                    beyond.append(f"{module} imports {library}")
        idle = [
            f"{room} lists {library}" for room in allowed for library in sorted(allowed[room] - used[room])
        ]
        return ContractCheck(kept=not (beyond or idle), metadata={"beyond": beyond, "idle": idle})

    def render_broken_contract(self, check):  # type: ignore[no-untyped-def]
        """Print what is wrong."""
        for line in check.metadata["beyond"]:
            output.print_error(f"{line}, which its room may not")
        for line in check.metadata["idle"]:
            output.print_error(f"{line}, which none of its modules imports")
