"""A contract for import-linter: a package that uses the rest of the project through its public interface only."""

from importlinter import Contract, ContractCheck, fields, output


class PublicInterfaceOnly(Contract):
    """Modules of ``room`` import from ``root`` only ``root`` itself and each other."""

    root = fields.StringField()
    room = fields.StringField()

    def check(self, graph, verbose):  # type: ignore[no-untyped-def]
        """Return the imports of internals."""
        own = {self.room, *graph.find_descendants(self.room)}
        internal = [
            f"{module} imports {imported}"
            for module in sorted(own)
            for imported in sorted(graph.find_modules_directly_imported_by(module))
            if imported.startswith(f"{self.root}.") and imported not in own
        ]
        return ContractCheck(kept=not internal, metadata={"internal": internal})

    def render_broken_contract(self, check):  # type: ignore[no-untyped-def]
        """Print what is wrong."""
        for line in check.metadata["internal"]:
            output.print_error(f"{line}, which is not public")
