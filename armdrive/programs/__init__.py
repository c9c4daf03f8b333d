"""Programs: a small language for the calls of an arm, and how programs are run and rehearsed.

What `armdrive run stack.arm` does, step by step:

1. `program.read_program_file` reads the lines into a tree (language.grammar), and checks it as a
   whole (language.checking).
2. `ArmProgram.machine` looks up the arm's points; the `Machine` runs one line after the other until
   one needs an act of the arm.
3. `rehearsal.rehearse` runs a machine on a simulated twin; a refusal ends here, before anything
   moves.
4. `running.ProgramRun` runs a new machine on the arm itself: it gives each act to the `Performer`
   and the answer back to the machine.
5. Before each act, `Journal` writes the state down, --step waits for Enter, and `Display` shows
   the line.

A rehearsal is the same `ProgramRun` with another performer. A Python script
has no machine: its calls of the arm are watched instead, see `scripts`.

Which file decides what:

    language/         from text to a checked tree: words, grammar, checks
    program           a checked program, and the machine that runs it line by line: which line
                      comes next, and how many it may run without an act
    interpreter       what each word does, as acts; how values are computed
    acts              what a program can ask of an arm
    running           acts carried out on an arm; the person; how pauses and stops affect delays
    rehearsal         the same acts on a simulated twin, its assumptions, and its time limit
    progress          the progress of a run, and its remaining time
    journal           the record of an interrupted run, and whether it may be resumed
    session, shell    lines typed at a prompt, and the table of the prompt's own words
    scripts           Python scripts on the chosen arm
    teaching          places of the arm written as lines of a program
    problems          mistakes in a program, shown below their line
    demonstration     blocks that are stacked: the program behind `armdrive demo`
"""

TYPE_CHECKING = False  # as typing's
if TYPE_CHECKING:
    from armdrive.programs.program import Program, read_program
else:

    def __getattr__(name: str) -> object:
        """Load what reads programs when it is first used: nothing else needs the parser."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from armdrive.programs import program

        return getattr(program, name)


__all__ = ["Program", "read_program"]
