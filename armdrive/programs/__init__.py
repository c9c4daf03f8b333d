"""Programs: a small language over the calls of an arm, and what runs and rehearses them.

What is decided where:

    language/         from text to instructions: words, grammar, checks, compiler
    program           a program that was read, and the machine that goes from line to line: how
                      many lines it may go without an act
    interpreter       what each word does, as acts; the bounds of calls and values
    acts              what a program can ask of an arm
    running           acts carried out on an arm; the person
    waits             delays of programs and sequences: what a pause and a stop do to them
    rehearsal         the same acts on a simulated twin, what is assumed, and when it gives up
    progress          how far a run is, and how long it still takes
    journal           what an interrupted run leaves, and whether it may be resumed
    session, shell    lines typed at a prompt, and the prompt's own words
    scripts           Python scripts on the chosen arm; `script_rehearsal` on its twin
    teaching/         sequences: recording, editing, stepping, exporting
    problems          mistakes in a program, shown below their line
"""

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
