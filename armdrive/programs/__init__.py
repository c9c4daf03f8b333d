"""Programs: a small language over the calls of an arm, and what runs and rehearses them."""

TYPE_CHECKING = False  # as typing's
if TYPE_CHECKING:
    from armdrive.programs.program import Program, read_program, written_program
else:

    def __getattr__(name: str) -> object:
        """Load what reads programs when it is first used: nothing else needs the parser."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from armdrive.programs import program

        return getattr(program, name)


__all__ = ["Program", "read_program", "written_program"]
